// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <algorithm>
#include <string_view>

#include "fuzz/nisar_fuzz_targets.h"
#include "products/import.h"

// As fuzz_targets.h, for products of TerraSAR-X.
namespace sarblock::fuzz {

/// The text up to `<geoReference` as an annotation, the rest as its GEOREF.xml.
inline TerraSarXProduct TerraSarXOf(std::string_view text) {
  const std::size_t at = std::min(text.find("<geoReference"), text.size());
  TerraSarXProduct product = ParseTerraSarX(text.substr(0, at), "a.xml");
  if (at < text.size()) AddGeoref(text.substr(at), "GEOREF.xml", &product);
  return product;
}

inline void TerraSarX(std::string_view text) {
  try {
    const TerraSarXProduct product = TerraSarXOf(text);
    for (const bool reduce : {false, true}) {
      ImportOptions options;
      options.reduce = reduce;
      options.points = ParseMatchedPoints("point,image,line,sample\nP,a,1,1\n", "points.csv");
      CheckImported(ImportProducts({product}, {}, options).block);
    }
  } catch (const InputError&) {
  }
}

}  // namespace sarblock::fuzz
