// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// A look of a pass at a known point and what the pass's given flight would have measured of it.
struct Sighting {
  std::size_t look = 0;
  double time_s = 0.0, range_m = 0.0;  ///< as measured
  double off_m = 0.0;  ///< how far the known position lies from the look's circle at its time
  bool on_its_side = false;
  // Where the known position comes abeam on the given path; NaN where it does not.
  double true_time_s = kNotGiven, true_range_m = kNotGiven;
  double ahead_sine_1 = kNotGiven;  ///< sine of the squint at which it is seen at the measured time
};

/// What one pass sees of the points whose position is known (control and check).
struct PassSightings {
  std::uint32_t pass = 0;
  Block part;  ///< the pass alone with these points
  std::vector<Sighting> sightings;
  double misfit_m = kNotGiven;  ///< median of off_m
  double speed_mps = 0.0;
};

/// Median of off_m over the looks of a block at its known points, which need not be solved: range
/// error and distance from the cone at the measured time, the whole range where the point is not on
/// the look's side or the time not on the path. NaN without known points.
[[nodiscard]] double MisfitOf(const Block& block);

/// A look and a position.
[[nodiscard]] Sighting SightingAt(const Block& block, std::size_t look, const Eigen::Vector3d& p_m);

/// Of every pass of the block.
[[nodiscard]] std::vector<PassSightings> SightingsOf(const Block& block);

/// Line through the median: b of y = a + b x from the pairs' slopes (Theil and Sen), and a.
struct Line {
  double offset = 0.0, slope = 0.0;
  double spread = 0.0;  ///< median distance from it
};
[[nodiscard]] Line RobustLine(const std::vector<double>& x, const std::vector<double>& y);

[[nodiscard]] double Median(std::vector<double> values);

}  // namespace sarblock
