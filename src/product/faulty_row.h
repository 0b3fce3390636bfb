// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace sarblock {

/// What is wrong with a grid point.
enum class GridFault {
  kPosition,  ///< time and position contradict each other: its look is rejected
  kHeight,    ///< fits once the height changes: latitude and longitude belong to another height
};

/// The faulty points of one kind in one row of a geolocation grid.
struct FaultyRow {
  std::string file;
  std::size_t file_line = 0;  ///< of the first faulty point's element; 0: the file has no lines
  GridFault fault = GridFault::kPosition;
  int line = 0;             ///< image line of the row
  std::size_t row = 0;      ///< from 1
  bool same_time = false;   ///< the row's time is that of the row before
  bool used = true;         ///< the grid's points become points of the block
  std::size_t points = 0;   ///< faulty ones
  std::size_t of = 0;       ///< all in the row
  double along_m[2] = {};   ///< smallest and largest e_d
  double range_m[2] = {};   ///< smallest and largest e_r
  double height_m[2] = {};  ///< kHeight: smallest and largest change that makes the range fit
};
/// `FILE:LINE: geolocationGrid line 13652 (row 10): ...`, one line of text.
[[nodiscard]] std::string Describe(const FaultyRow& row);

}  // namespace sarblock
