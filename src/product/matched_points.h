// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// A point as it was measured in one image.
struct MatchedPoint {
  std::string point;
  std::string image;  ///< id of a pass, or name of a file, with or without folder and ending
  double line_px = 0.0, sample_px = 0.0;
  double line_sigma_px = kNotGiven, sample_sigma_px = kNotGiven;
  std::size_t file_line = 0;
};

/// A table of points matched in images, whoever matched them.
struct MatchedPoints {
  std::string file;
  /// Line and sample of the centre of the first pixel in the table's numbers. 0: centres at whole
  /// numbers from 0 on; 0.5: the first pixel's upper left corner is 0, 0; 1: as ISIS and MATLAB.
  std::array<double, 2> origin_px{0.0, 0.0};
  std::vector<MatchedPoint> rows;
  std::vector<std::string> warnings;  ///< columns that are not known
};

/// Reads CSV with the columns point, image, line, sample and, optionally, line_sigma_px and
/// sample_sigma_px, plain or gzip. Throws InputError with file, line and column. docs/import.md.
[[nodiscard]] MatchedPoints ReadMatchedPoints(const std::string& file);
/// The same of a text in memory; `file` is for messages.
[[nodiscard]] MatchedPoints ParseMatchedPoints(std::string_view text, const std::string& file);

}  // namespace sarblock
