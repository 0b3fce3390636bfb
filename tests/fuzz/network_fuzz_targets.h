// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

#include "products/csm.h"
#include "products/import.h"
#include "products/isis.h"

// As fuzz_targets.h, for networks and their images.
namespace sarblock::fuzz {

inline void CheckNetworkBlock(const Block& block) {
  const auto check = [](bool holds) {
    if (!holds) std::abort();
  };
  check(block.looks.size() > 0 && block.points.size() > 0);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    check(std::isfinite(block.looks.time_s[i]) && block.looks.range_m[i] > 0.0);
    const Pass& pass = block.passes[block.looks.pass[i]];
    check(pass.path.At(block.looks.time_s[i]).has_value());
    check(block.SigmaOf(i).range_m > 0.0 && block.SigmaOf(i).azimuth > 0.0);
  }
  for (const Pass& pass : block.passes) check(pass.start_s < pass.end_s);
}

inline NetworkImportOptions FuzzedImport() {
  NetworkImportOptions options;
  options.missing = MissingImages::kLeaveOut;
  options.range_sigma_m = options.azimuth_sigma_m = options.control_sigma_m = 5.0;
  options.height_sigma_m = 1.0;
  return options;
}

/// An image that every network fits: a straight flight at the height of 50 km, its serial number
/// that of the network.
inline RadarImage PlainImage(const std::string& serial) {
  RadarImage image;
  image.file = "plain.cub";
  image.serial = serial;
  image.ellipsoid = {"", 1737400.0, 0.0};
  image.lines = image.samples = 4000;
  image.line_interval_s = 0.01;
  image.sample_spacing_m = 15.0;
  image.wavelength_m = 0.126;
  image.ground_range = {{0.0, 0.0, {50000.0, 0.7, 4e-6}}, {20.0, 0.0, {50001.0, 0.7, 4e-6}}};
  for (const double time_s : {-100.0, 100.0}) {
    image.states.push_back({time_s, {1787400.0, 0.0, 1600.0 * time_s}, {0.0, 0.0, 1600.0}});
  }
  return image;
}

/// The bytes as a control network, imported with one image for each of its first serial numbers.
inline void Network(std::string_view bytes) {
  try {
    const ControlNetwork network = ParseControlNetwork(bytes, "a.net");
    std::vector<RadarImage> images;
    for (std::size_t i = 0; i < network.serials.size() && i < 4; ++i) {
      images.push_back(PlainImage(network.serials[i]));
      images.back().file = std::to_string(i) + ".cub";
    }
    CheckNetworkBlock(ImportNetwork(network, images, FuzzedImport()).block);
  } catch (const InputError&) {
  }
}

/// One measure in an image, imported both ways of reading its polynomials.
inline void Measure(const RadarImage& image) {
  ControlNetwork network;
  network.file = "a.net";
  network.serials = {image.serial.empty() ? "a" : image.serial};
  NetworkPoint point;
  point.id = "P";
  point.measures.push_back({.line_px = 10.0, .sample_px = 20.0});
  network.points = {point};
  NetworkImportOptions options = FuzzedImport();
  options.serials = {{network.serials.front(), 0}};
  for (const auto reading : {RangePolynomialTimes::kGiven, RangePolynomialTimes::kUsgscsm}) {
    options.range_polynomial = reading;
    CheckNetworkBlock(ImportNetwork(network, {image}, options).block);
  }
}

/// The bytes as a cube of ISIS.
inline void Cube(std::string_view bytes) {
  try {
    Measure(ParseIsisCube(bytes, "a.cub"));
  } catch (const InputError&) {
  }
}

/// The text as an ISD.
inline void Isd(std::string_view text) {
  try {
    Measure(ParseCsmIsd(text, "a.json"));
  } catch (const InputError&) {
  }
}

}  // namespace sarblock::fuzz
