// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Measured values of a look in one row of observations.csv.
struct RowValues {
  double time_s = kNotGiven, range_m = kNotGiven, cone = 0.0;
};

/// A part of a block that shows what the whole does: known points and tie points spread evenly over
/// pairs of passes and over the points of each, and the points that contradict themselves most.
struct Sample {
  Block block;
  /// Points of `block` whose looks meet much worse than those of others: suspects, worst first.
  std::vector<std::uint32_t> suspects;
  /// By look of `block`: the values of the rows before and after it among those of its pass, in the
  /// order of points and in the order of times.
  enum Neighbour : std::size_t { kPointBefore, kPointAfter, kTimeBefore, kTimeAfter };
  std::vector<std::array<RowValues, 4>> neighbours;
};

[[nodiscard]] Sample TakeSample(const Block& block, ProgressSink* progress);

/// Misfit of the looks of a point on the given paths [m]; for a known point their distance from it.
/// NaN if it has none.
[[nodiscard]] double ContradictionOf(const Block& block, std::uint32_t point);

/// Index of a pass; nothing where the block has none of this id.
[[nodiscard]] std::optional<std::uint32_t> FindPass(const Block& block, const std::string& id);

/// Passes of these ids that the block has, all of them for an empty list.
[[nodiscard]] std::vector<std::uint32_t> PassesOf(const Block& block,
                                                  const std::vector<std::string>& ids);

/// Calls `edit` for every look of these passes (empty: all).
void ForLooks(const Block& block,
              const std::vector<std::string>& passes,
              const std::function<void(std::size_t look)>& edit);

/// Changes the states of a pass as recorded and makes its path of them in the way asked for.
/// Changes that leave no valid path leave the pass as it was.
void EditStates(const std::function<void(StateVector*)>& edit, std::size_t pass, Block* block);

/// Changes the states of the path of a pass as it was read, which are not read anew: for changes
/// that leave a smooth path smooth.
void EditPathAsRead(const std::function<void(StateVector*)>& edit, std::size_t pass, Block* block);

/// Reads these passes (empty: all) as `auto` decides. Where no path can be made so they stay as
/// they were.
void ReadWithAuto(const std::vector<std::string>& passes, Block* block);

/// Sets a strip to the span of its looks where some of them lie beyond its ends.
void FitStrips(Block* block);

/// Block of some points with their looks, in the order given; passes as they are. `look_of`, where
/// given, becomes the look of `block` that each of its looks is.
[[nodiscard]] Block PartOf(const Block& block,
                           const std::vector<std::uint32_t>& points,
                           std::vector<std::size_t>* look_of = nullptr);

/// The same of one pass alone.
[[nodiscard]] Block PartOfPass(const Block& block,
                               std::uint32_t pass,
                               const std::vector<std::uint32_t>& points);

/// A look of a pass at a known point and what the pass's given flight would have measured of it.
struct PredictedLook {
  std::size_t look = 0;
  double time_s = 0.0, range_m = 0.0;  ///< as measured
  double off_m = 0.0;  ///< how far the known position lies from the look's circle at its time
  bool on_its_side = false;
  // Where the known position comes abeam on the given path; NaN where it does not.
  double true_time_s = kNotGiven, true_range_m = kNotGiven;
  double ahead_sine = kNotGiven;  ///< sine of the squint at which it is seen at the measured time
};

/// What one pass sees of the points whose position is known (control and check).
struct PassPredictions {
  std::uint32_t pass = 0;
  Block part;  ///< the pass alone with these points
  std::vector<PredictedLook> predictions;
  double misfit_m = kNotGiven;  ///< median of off_m
  double speed_mps = 0.0;
};

/// Median of off_m over the looks of a block at its known points, which need not be solved: range
/// error and distance from the cone at the measured time, the whole range where the point is not on
/// the look's side or the time not on the path. NaN without known points.
[[nodiscard]] double MisfitOf(const Block& block);

/// Predicts a look at a position.
[[nodiscard]] PredictedLook PredictLook(const Block& block,
                                        std::size_t look,
                                        const Eigen::Vector3d& p_m);

/// Predicted looks of every pass of the block.
[[nodiscard]] std::vector<PassPredictions> PredictLooks(const Block& block);

/// Line through the median: b of y = a + b x from the pairs' slopes (Theil and Sen), and a.
struct Line {
  double offset = 0.0, slope = 0.0;
  double spread = 0.0;  ///< median distance from it
};
[[nodiscard]] Line RobustLine(const std::vector<double>& x, const std::vector<double>& y);

[[nodiscard]] double Median(std::vector<double> values);

}  // namespace sarblock
