// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"

#include <array>
#include <cstdint>
#include <vector>

namespace sarblock {

/// A look as some row of observations.csv gives it.
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

/// How badly the looks of a point meet on the given paths, in metres; of a known point how far they
/// pass it by. NaN where there is nothing to tell.
[[nodiscard]] double ContradictionOf(const Block& block, std::uint32_t point);

}  // namespace sarblock
