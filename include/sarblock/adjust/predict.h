// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// The covariance that an adjustment of this block would have, from geometry and weights alone.
/// `positions_m` are the points' positions (truth or approximate); a point without one is
/// intersected from its measurements if it has some. Looks without measured time or range get
/// those of the geometry; with `looks` empty every pass that sees a point on its look side within
/// its path takes a look.
[[nodiscard]] AdjustResult Predict(const Block& block,
                                   const AdjustOptions& options,
                                   const std::vector<Eigen::Vector3d>& positions_m,
                                   const PointPairs& pairs = {},
                                   ProgressSink* progress = nullptr);

/// Fills time and range of looks that have none from the geometry of known positions on the nominal
/// paths; adds all visible looks where the block has none at all. Looks and points that cannot be
/// filled are left out of the result's looks.
[[nodiscard]] Block FillMeasurements(const Block& block,
                                     const std::vector<Eigen::Vector3d>& positions_m);

}  // namespace sarblock
