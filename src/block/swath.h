// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Why a pass does not see a position: the first of these that applies.
enum class Unseen { kBeyondStrip, kWrongSide, kBelowHorizon, kOutsideSwath };

/// Whether a pass sees the position p from `motion`: p lies on the look side, the antenna above the
/// horizontal plane at p, and p within the swath, where the pass has one. There is no shadow and no
/// layover.
[[nodiscard]] bool IsSeen(const Frame& frame,
                          const Pass& pass,
                          const Motion& motion,
                          const Eigen::Vector3d& p_m);

/// The time of the look that a pass takes at p with its squint, on its path and within its strip's
/// time; nothing where it does not see p, and then `why` (may be null) says why.
[[nodiscard]] std::optional<double> TimeSeen(const Frame& frame,
                                             const Pass& pass,
                                             const Eigen::Vector3d& p_m,
                                             Unseen* why = nullptr);

/// The largest slant range of a swath: its ground is `depth_m` below the antenna, which is
/// `antenna_radius_m` and the ground `ground_radius_m` from the centre of the body; both are
/// infinite over a plane. NaN where the far limit looks past the horizon.
[[nodiscard]] double FarRange(const Swath& swath,
                              double depth_m,
                              double antenna_radius_m,
                              double ground_radius_m);

/// A position counts as outside a swath if it is beyond a limit by more than this part of the
/// swath's width: paths with errors see a little more or less than the planned ones.
inline constexpr double kSwathMargin = 0.05;

/// One sentence for each kind of swath that has looks at positions outside of it: how many, and the
/// one farthest outside. `positions_m` are by point (not finite: left out), `look_used` by look (0:
/// left out).
[[nodiscard]] std::vector<std::string> FindLooksOutsideSwath(
    const Block& block,
    const std::vector<Eigen::Vector3d>& positions_m,
    const std::vector<std::uint8_t>& look_used);

/// The looks of a block that have a time and are not rejected.
struct Coverage {
  double looks_per_point = 0.0;  ///< mean of all points
  std::size_t fewest = 0, most = 0;
  std::vector<std::size_t> points_by_looks;  ///< points with k looks, k from 0 to `most`
  double least_look_rad = kNotGiven, most_look_rad = kNotGiven;  ///< look angles off nadir
};
/// `positions_m` are by point; looks at points without one are left out.
[[nodiscard]] Coverage CoverageOf(const Block& block,
                                  const std::vector<Eigen::Vector3d>& positions_m);
/// "2.8 looks per point (0 to 4) at look angles of 32 to 51 degrees".
[[nodiscard]] std::string Describe(const Coverage& coverage);

/// Warning about looks that were planned because a block has none: their number and look angles,
/// where not every pass has a swath. Else nothing.
[[nodiscard]] std::optional<std::string> WarningOfPlan(
    const Block& planned, const std::vector<Eigen::Vector3d>& positions_m);

}  // namespace sarblock
