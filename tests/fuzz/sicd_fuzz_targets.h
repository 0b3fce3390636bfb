// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

#include "exchange/sicd_offsets.h"
#include "fuzz/nisar_fuzz_targets.h"
#include "products/import.h"
#include "products/sicd.h"

// As fuzz_targets.h, for SICD images.
namespace sarblock::fuzz {

/// Where NitfOf() puts the length of its data extension segment.
inline constexpr std::size_t kNitfDesLengthAt = 363 + 16 + 3 + 3 + 3 + 3 + 4;

/// A NITF file with an image of 8 bytes and a text in a data extension segment: of the header the
/// fields that count segments and their lengths, blanks elsewhere.
inline std::string NitfOf(std::string_view text) {
  const auto digits = [](std::size_t value, int count) {
    char field[32];
    std::snprintf(field, sizeof field, "%0*zu", count, value);
    return std::string(field);
  };
  constexpr std::size_t kImageHead = 439, kImage = 8, kDesHead = 200;
  std::string header = "NITF02.10" + std::string(333, ' ') + digits(0, 12) + "HHHHHH";
  header += "001" + digits(kImageHead, 6) + digits(kImage, 10);  // NUMI, LISH, LI
  header += "000000000001" + digits(kDesHead, 4);                // NUMS, NUMX, NUMT, NUMDES, LDSH
  header += digits(text.size(), 9) + "000";                      // LD, NUMRES
  header.replace(354, 6, digits(header.size(), 6));
  std::string subheader = "DEXML_DATA_CONTENT";
  subheader.resize(kDesHead, ' ');
  return header + std::string(kImageHead + kImage, ' ') + subheader + std::string(text);
}

/// The bytes as a SICD image.
inline void Sicd(std::string_view bytes) {
  try {
    ImportOptions options;
    options.points = ParseMatchedPoints("point,image,line,sample\nP,a,1,1\n", "points.csv");
    CheckImported(ImportProducts({ParseSicd(bytes, "a.nitf")}, {}, options).block);
    // What is written of it is read again.
    const AdjustedSicd adjusted = AdjustSicd(bytes, "a.nitf", {});
    static_cast<void>(ParseSicd(adjusted.text, "b.xml"));
  } catch (const InputError&) {
  }
}

}  // namespace sarblock::fuzz
