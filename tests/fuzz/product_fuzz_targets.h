// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

#include "products/import.h"

// As fuzz_targets.h, for the readers of products.
namespace sarblock::fuzz {

/// The text as an annotation and as an orbit file. What is read is imported; an imported block has
/// an entry for every grid point, finite looks and passes that their paths cover.
inline void Product(std::string_view text) {
  const auto check = [](bool holds) {
    if (!holds) std::abort();
  };
  try {
    const Sentinel1Product product = ParseSentinel1(text, "a.xml");
    const Block block = ImportProducts({product}, {}, ImportOptions{}).block;
    check(block.looks.size() == product.grid.size() && block.points.size() == product.grid.size());
    for (std::size_t i = 0; i < block.looks.size(); ++i) {
      check(std::isfinite(block.looks.time_s[i]) && block.looks.range_m[i] > 0.0);
      check(block.passes[0].path.At(block.looks.time_s[i]).has_value());
    }
    check(block.passes[0].start_s < block.passes[0].end_s);
    check(block.passes[0].sigma.range_m > 0.0 && block.passes[0].sigma.azimuth > 0.0);
  } catch (const InputError&) {
  }
  try {
    check(ParseOrbitFile(text, "o.EOF").states.size() >= 2);
  } catch (const InputError&) {
  }
}

}  // namespace sarblock::fuzz
