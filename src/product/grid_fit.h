// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/look_equations.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "product/faulty_row.h"

namespace sarblock {

/// What a geolocation grid says of one place: seen at this time and range.
struct GridPoint {
  double time_s = 0.0;
  double range_m = 0.0;
  Geodetic place;
  Cone cone{};  ///< zero Doppler, or the Doppler measured at the time
};

/// How one grid point fits the orbit.
struct GridFit {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< as the product gives it
  double range_error_m = 0.0;                            ///< e_r
  double along_error_m = 0.0;                            ///< e_d
  double height_change_m = 0.0;    ///< what makes e_r vanish; 0 unless the fault is kHeight
  std::optional<GridFault> fault;  ///< none: good
  LookSide side = LookSide::kRight;
};

/// Fit of a grid point; nothing where its time is outside the path.
[[nodiscard]] std::optional<GridFit> FitGridPoint(const GridPoint& point,
                                                  const Frame& frame,
                                                  const FlightPath& path,
                                                  double max_misfit_m);

/// Collects the faulty points of a grid by row and fault, rows in the order in which they come.
class FaultyRows {
 public:
  explicit FaultyRows(std::string file) : file_(std::move(file)) {}
  /// A new row at an image line; `same_time` says that its time is that of the row before.
  void Begin(int line, bool same_time);
  /// The next point of the row; `file_line` is the line of its element, 0 where there is none.
  void Add(const GridFit& fit, std::size_t file_line);
  [[nodiscard]] std::vector<FaultyRow> Take();

 private:
  void End();
  std::string file_;
  std::vector<FaultyRow> rows_;
  std::vector<FaultyRow> current_;  // one a fault
  std::size_t count_ = 0;           // of rows
  std::size_t points_ = 0;          // of the current row
};

}  // namespace sarblock
