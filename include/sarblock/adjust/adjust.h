// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// The adjustment of a block (model.md, sections 5 to 7): start values, Levenberg-Marquardt,
/// acceptance, covariance, residuals, check points, global test.
///
/// Weights depend (weakly) on the unknowns where azimuth is given in metres: they are formed at the
/// start, where the solution has come near, and with every finishing Newton step.
/// Under a robust loss the looks whose whitened length exceeds the 99.9 percent point of chi-square
/// with 2 degrees of freedom are dropped after the robust solution; the result is that of least
/// squares with the looks kept.
/// Accepted means: every look has a value at the solution, the reduced matrix is regular, and the
/// Newton decrement is below kRemainingStepAccepted (under a loss also that of the robust
/// solution below kRemainingRobustStepAccepted).
///
/// Reductions by the models of Pass::reduction are subtracted from the looks first, at the start
/// positions of the points, and again at the solved positions until they no longer change; known
/// points with a velocity are moved to the dates of the images. Only blocks with such models or
/// velocities are copied.
///
/// The result lists points as the block does. The sums over points may be taken in another order,
/// that of the passes that see them (docs/performance.md), the same for the same block.
///
/// `pairs` is used with options.pairs == kList. Throws InputError for a block that Validate()
/// refuses, a look without a time or range, a path deep below the ground, pairs with a point that
/// does not exist or of a point with itself, and options that do not fit the block;
/// UndeterminedError where the block as a whole or its corrections are not determined; Interrupted.
/// A point that is not determined is reported with its reason and left out.
[[nodiscard]] AdjustResult Adjust(const Block& block,
                                  const AdjustOptions& options,
                                  const PointPairs& pairs = {},
                                  ProgressSink* progress = nullptr);

/// The same in less memory for a block of many passes whose points are not in the order of the
/// passes: they are sorted for the time of the adjustment, which needs no copy of a block that may
/// be changed. On return, also by an exception (except when memory ran out), the block is as it
/// was.
[[nodiscard]] AdjustResult Adjust(Block* block,
                                  const AdjustOptions& options,
                                  const PointPairs& pairs = {},
                                  ProgressSink* progress = nullptr);

/// The covariance that an adjustment of this block would have, from geometry and weights alone.
/// `positions_m` are the points' positions (truth or approximate); a point without one is
/// intersected from its measurements if it has some. Looks without measured time or range get
/// those of the geometry; with `looks` empty (Looks{} is enough) every pass takes a look at each
/// point that it sees with its squint: on its look side, within its strip's time, its path and its
/// swath. Passes without a swath see far more than an image shows: the result warns of it. Throws
/// what Adjust() does, and InputError for more positions than points.
[[nodiscard]] AdjustResult Predict(const Block& block,
                                   const AdjustOptions& options,
                                   const std::vector<Eigen::Vector3d>& positions_m,
                                   const PointPairs& pairs = {},
                                   ProgressSink* progress = nullptr);

/// Makes the path of every pass from its recorded states (RecordedStates()) in the way that
/// Pass::recorded.asked says: through the states, as an orbit, through the positions, or smoothed
/// (docs/theory/flight_path.md#recorded-flights). kAuto takes the first of these whose error stays
/// below a tenth of the standard deviation of azimuth, or the one of least error. Looks and strip
/// spans must be set. Returns warnings: recordings whose errors matter, with what helps. Throws
/// InputError for a block that Validate() refuses and for states that cannot be read in any of
/// these ways.
[[nodiscard]] std::vector<std::string> MakePaths(Block* block);

/// Fills time and range of looks that have none from the geometry of known positions on the nominal
/// paths; adds all visible looks where the block has none at all. Looks and points that cannot be
/// filled are left out of the result's looks. Throws InputError for a block that Validate() refuses
/// and unless there is one position for each point.
[[nodiscard]] Block FillMeasurements(const Block& block,
                                     const std::vector<Eigen::Vector3d>& positions_m);

/// Rigorous intersection of every point, flight paths fixed (corrections none): position,
/// covariance R^-1 R^-T and residuals of each point alone, control not used. Throws what Adjust()
/// does of a block.
[[nodiscard]] AdjustResult IntersectBlock(const Block& block,
                                          const AdjustOptions& options,
                                          ProgressSink* progress = nullptr);

/// What CheckBlock() finds in a block before any equation is formed.
struct BlockCheck {
  int corrections = 0;                ///< parameters of the corrections given
  std::vector<std::string> findings;  ///< problems that an adjustment will have, and their remedies
  ResourceNeeds needs;                ///< of an adjustment with the corrections given
};

/// Examines the network configuration of a block and, on its start values, the points that its
/// looks leave open. Throws InputError for a block that Validate() refuses and for options that do
/// not fit the block, UndeterminedError, Interrupted.
[[nodiscard]] BlockCheck CheckBlock(const Block& block,
                                    const AdjustOptions& options,
                                    ProgressSink* progress = nullptr);

}  // namespace sarblock
