// SPDX-License-Identifier: Apache-2.0
#include "image_passes.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "ephemeris_time.h"
#include "orbit_path.h"
#include "range_polynomial.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

// The time of an id: 20221016T015044.
std::string CompactTime(const UtcTime& time) {
  std::string text = UtcText(time);
  std::erase_if(text, [](char c) { return c == '-' || c == ':' || c == 'Z'; });
  return text;
}

// S1A of an annotation and Sentinel-1A of an orbit file name the same satellite.
bool SameMission(const std::string& product, const std::string& orbit) {
  return !product.empty() && !orbit.empty() &&
         (product == orbit || (orbit.starts_with("Sentinel-") && product == "S" + orbit.substr(9)));
}

/// Times of the product's image and grid, from its epoch.
struct Span {
  double start_s = 0.0, end_s = 0.0;
  void Include(double time_s) {
    start_s = std::min(start_s, time_s);
    end_s = std::max(end_s, time_s);
  }
};
Span SpanOf(const Sentinel1Product& product, const UtcTime& epoch) {
  Span span{SecondsBetween(epoch, product.first_line), SecondsBetween(epoch, product.last_line)};
  for (const GeolocationGridPoint& point : product.grid) {
    span.Include(SecondsBetween(epoch, point.time));
  }
  return span;
}

// States of the first orbit file of the mission that covers the product, with margin as far as it
// goes.
std::vector<StateVector> StatesOfFiles(const std::vector<OrbitFile>& orbits,
                                       const Sentinel1Product& product,
                                       const UtcTime& epoch,
                                       double margin_s) {
  const Span span = SpanOf(product, epoch);
  for (const OrbitFile& orbit : orbits) {
    if (!SameMission(product.mission, orbit.mission)) continue;
    std::vector<StateVector> states = StatesFrom(orbit.states, epoch);
    if (states.front().time_s > span.start_s || states.back().time_s < span.end_s) continue;
    const auto from = std::find_if(states.begin(), states.end(), [&](const StateVector& state) {
      return state.time_s >= span.start_s - margin_s;
    });
    const auto to = std::find_if(states.begin(), states.end(), [&](const StateVector& state) {
      return state.time_s > span.end_s + margin_s;
    });
    // One state more on both sides: the span with its margin then lies inside the path.
    return {from == states.begin() ? from : from - 1, to == states.end() ? to : to + 1};
  }
  std::string files;
  for (const OrbitFile& orbit : orbits) {
    files += fmt::format("{}{} ({}, {} to {})",
                         files.empty() ? "" : "; ",
                         orbit.file,
                         orbit.mission,
                         UtcText(orbit.states.front().time),
                         UtcText(orbit.states.back().time));
  }
  throw InputError(FilePlace{product.file, 0, "orbit"},
                   fmt::format("no orbit file covers this product ({}, {} to {}); given: {}",
                               product.mission,
                               UtcText(product.first_line),
                               UtcText(product.last_line),
                               files));
}

ImageGrid ImageOf(const Sentinel1Product& product, const UtcTime& epoch) {
  ImageGrid image;
  image.presentation = product.presentation;
  image.first_line_s = SecondsBetween(epoch, product.first_line);
  image.line_interval_s = product.line_interval_s;
  image.near_range_m = product.near_range_m;
  image.range_spacing_m = product.range_spacing_m;
  for (const ProductGroundRange& polynomial : product.ground_range) {
    image.ground_range.push_back(
        {SecondsBetween(epoch, polynomial.time), polynomial.origin_m, polynomial.coefficients});
  }
  for (const UtcTime& burst : product.bursts) {
    image.burst_start_s.push_back(SecondsBetween(epoch, burst));
  }
  image.lines_per_burst = static_cast<std::size_t>(product.lines_per_burst);
  return image;
}

ImageGrid ImageOf(const NisarProduct& product, const UtcTime& epoch) {
  ImageGrid image;
  image.first_line_s = SecondsBetween(epoch, product.first_line);
  image.line_interval_s = product.line_interval_s;
  image.near_range_m = product.near_range_m;
  image.range_spacing_m = product.range_spacing_m;
  return image;
}

ImageGrid ImageOf(const RadarImage& image, RangePolynomialTimes reading, double epoch_s) {
  ImageGrid grid;
  grid.presentation = Presentation::kGround;
  grid.first_line_s = image.first_line_s - epoch_s;
  grid.line_interval_s = image.line_interval_s;
  grid.near_range_m = image.first_sample_m;
  grid.range_spacing_m = image.sample_spacing_m;
  grid.ground_range = image.ground_range;
  if (reading == RangePolynomialTimes::kUsgscsm) {
    grid.ground_range =
        AsUsgscsmReads(image.ground_range, image.states.front().time_s, image.states.back().time_s);
  }
  for (GroundRangePolynomial& polynomial : grid.ground_range) polynomial.time_s -= epoch_s;
  return grid;
}

}  // namespace

ImagePass PassOfSentinel1(const Sentinel1Product& product,
                          const std::vector<OrbitFile>& orbits,
                          const ImportOptions& options,
                          std::vector<std::string>* warnings) {
  ImagePass image{.file = product.file, .ellipsoid = NamedEllipsoid("WGS84")};
  Pass& pass = image.pass;
  pass.id = product.mission + "_" + product.swath + "_" + product.polarisation + "_" +
            CompactTime(product.first_line);
  image.first_line = product.first_line;
  const UtcTime epoch = SetEpoch(product.first_line, &pass);
  pass.wavelength_m = product.wavelength_m;
  pass.path = PathThroughOrbit(product.file,
                               orbits.empty()
                                   ? StatesFrom(product.orbit, epoch)
                                   : StatesOfFiles(orbits, product, epoch, options.orbit_margin_s),
                               options.orbit_step_s,
                               options.through,
                               warnings);
  pass.image = ImageOf(product, epoch);
  CheckImageGrid(*pass.image);
  const Span span = SpanOf(product, epoch);
  image.span_s = {span.start_s, span.end_s};
  const GeolocationGridPoint& middle = product.grid[product.grid.size() / 2];
  image.middle = {SecondsBetween(epoch, middle.time), middle.slant_range_m};
  return image;
}

ImagePass PassOfNisar(const NisarProduct& product,
                      const ImportOptions& options,
                      std::vector<std::string>* warnings) {
  ImagePass image{.file = product.file, .ellipsoid = NamedEllipsoid("WGS84")};
  image.lines = product.lines;
  image.samples = product.samples;
  Pass& pass = image.pass;
  pass.id = "NISAR_" + product.band + "_" + product.frequency.back() + "_" +
            CompactTime(product.first_line);
  image.first_line = product.first_line;
  const UtcTime epoch = SetEpoch(product.first_line, &pass);
  pass.side = product.side;
  pass.wavelength_m = product.wavelength_m;
  pass.path = PathThroughOrbit(product.file,
                               StatesFrom(product.orbit, epoch),
                               options.orbit_step_s,
                               options.through,
                               warnings);
  pass.image = ImageOf(product, epoch);
  Span span{SecondsBetween(epoch, product.first_line), SecondsBetween(epoch, product.last_line)};
  if (!pass.path.At(span.start_s) || !pass.path.At(span.end_s)) {
    throw InputError(FilePlace{product.file, 0, "metadata/orbit/time"},
                     fmt::format("covers {:.3f} to {:.3f} s after {}, the image {:.3f} to {:.3f} s",
                                 pass.path.start_s(),
                                 pass.path.end_s(),
                                 UtcText(epoch),
                                 span.start_s,
                                 span.end_s));
  }
  image.middle = {0.5 * (span.start_s + span.end_s),
                  product.near_range_m +
                      0.5 * static_cast<double>(product.samples - 1) * product.range_spacing_m};
  if (options.grid) {
    for (const UtcTime& time : product.grid.time) span.Include(SecondsBetween(epoch, time));
  }
  image.span_s = {span.start_s, span.end_s};
  return image;
}

ImagePass PassOfRadarImage(const RadarImage& given, RangePolynomialTimes range_polynomial) {
  ImagePass image{.file = given.file, .ellipsoid = given.ellipsoid};
  Pass& pass = image.pass;
  pass.id = std::filesystem::path(given.file).stem().string();
  image.first_line = UtcOfEphemerisTime(given.first_line_s);
  const UtcTime epoch = SetEpoch(image.first_line, &pass);
  const double epoch_s = EphemerisTime_s(epoch);
  pass.side = given.side;
  pass.wavelength_m = given.wavelength_m;
  std::vector<StateVector> states = given.states;
  for (StateVector& state : states) state.time_s -= epoch_s;
  try {
    pass.image = ImageOf(given, range_polynomial, epoch_s);
    pass.path = FlightPath(std::move(states));
    CheckImageGrid(*pass.image);
  } catch (const InputError& error) {
    throw InputError(FilePlace{given.file, 0, ""}, error.what());
  }
  image.lines = given.lines;
  image.samples = given.samples;
  image.middle = RadarFromImage(
      *pass.image,
      {0.5 * static_cast<double>(given.lines - 1), 0.5 * static_cast<double>(given.samples - 1)});
  return image;
}

}  // namespace sarblock
