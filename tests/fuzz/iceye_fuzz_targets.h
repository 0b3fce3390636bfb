// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <string_view>

#include "fuzz/nisar_fuzz_targets.h"
#include "products/import.h"

// As fuzz_targets.h, for metadata of ICEYE images.
namespace sarblock::fuzz {

inline void Iceye(std::string_view text) {
  try {
    ImportOptions options;
    options.points = ParseMatchedPoints("point,image,line,sample\nP,a,1,1\n", "points.csv");
    CheckImported(ImportProducts({ParseIceye(text, "a.xml")}, {}, options).block);
  } catch (const InputError&) {
  }
}

}  // namespace sarblock::fuzz
