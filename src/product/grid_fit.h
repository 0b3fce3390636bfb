// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/product/faulty_row.h"
#include "sarblock/product/sentinel1.h"

#include <optional>
#include <vector>

namespace sarblock {

/// How one grid point fits the orbit.
struct GridFit {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< as the product gives it
  double time_s = 0.0;
  double range_error_m = 0.0;      ///< e_r
  double along_error_m = 0.0;      ///< e_d
  double height_change_m = 0.0;    ///< what makes e_r vanish; 0 unless the fault is kHeight
  std::optional<GridFault> fault;  ///< none: good
  LookSide side = LookSide::kRight;
};

/// Fits of all grid points of a product, in its order. Times count from `epoch`. Throws InputError
/// at a point whose time is outside the path.
[[nodiscard]] std::vector<GridFit> FitGrid(const Sentinel1Product& product,
                                           const Frame& frame,
                                           const FlightPath& path,
                                           const UtcTime& epoch,
                                           double max_misfit_m);

/// The faulty rows, by line and fault.
[[nodiscard]] std::vector<FaultyRow> FaultyRowsOf(const Sentinel1Product& product,
                                                  const std::vector<GridFit>& fits);

}  // namespace sarblock
