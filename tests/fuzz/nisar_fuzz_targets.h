// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "fuzz/container_edit.h"
#include "fuzz/nisar_file.h"
#include "products/import.h"

// As fuzz_targets.h, for products of NISAR and for the tables of points that go with images.
namespace sarblock::fuzz {

inline void CheckImported(const Block& block) {
  const auto check = [](bool holds) {
    if (!holds) std::abort();
  };
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    check(std::isfinite(block.looks.time_s[i]) && block.looks.range_m[i] > 0.0);
    check(block.passes[block.looks.pass[i]].path.At(block.looks.time_s[i]).has_value());
    check(block.SigmaOf(i).range_m > 0.0 && block.SigmaOf(i).azimuth > 0.0);
  }
  for (const Pass& pass : block.passes) check(pass.start_s < pass.end_s);
}

/// A small RSLC, damaged by the lines of container_edit.h, read and imported. Bytes inside it are
/// not: what they mean is libhdf5's.
inline void Nisar(std::string_view lines, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "fuzz.h5";
  test::NisarFile{}.Write(file);
  ContainerEdit(file, lines);
  try {
    const NisarProduct product = ReadNisar(file);
    for (const auto grid :
         {std::optional<PointRole>(), std::optional<PointRole>(PointRole::kCheck)}) {
      ImportOptions options;
      options.grid = grid;
      CheckImported(ImportProducts({product}, {}, options).block);
    }
  } catch (const InputError&) {
  }
}

/// An image that tables of points are held against.
inline NisarProduct PlainProduct() {
  NisarProduct product;
  product.file = "a.h5";
  product.band = "LSAR";
  product.frequency = "frequencyA";
  product.side = LookSide::kLeft;
  product.wavelength_m = 0.24;
  product.lines = product.samples = 2000;
  product.first_line = {1'700'000'000, 0.25};
  product.last_line = {1'700'000'020, 0.24};
  product.line_interval_s = 0.01;
  product.near_range_m = 850'000.0;
  product.range_spacing_m = 5.0;
  for (int s = -40; s <= 60; s += 10) {
    product.orbit.push_back({{1'700'000'000 + s, 0.0},
                             test::NisarFile::Position_m(s),
                             test::NisarFile::Velocity_mps(s)});
  }
  return product;
}

/// The text as a table of matched points.
inline void Matches(std::string_view text) {
  try {
    ImportOptions options;
    options.points = ParseMatchedPoints(text, "points.csv");
    CheckImported(ImportProducts({PlainProduct()}, {}, options).block);
  } catch (const InputError&) {
  }
}

/// The text as a table of reflectors.
inline void ReflectorTable(std::string_view text) {
  try {
    ImportOptions options;
    options.reflectors = ParseReflectors(text, "reflectors.csv");
    options.reflector_role = PointRole::kCheck;
    CheckImported(ImportProducts({PlainProduct()}, {}, options).block);
  } catch (const InputError&) {
  }
}

}  // namespace sarblock::fuzz
