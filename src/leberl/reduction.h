// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/configuration.h"

#include <array>
#include <optional>

namespace sarblock::leberl {

/// A vector of the block's frame (any Cartesian axes).
using Triple = std::array<double, 3>;

/// One look of a pair as the reduction needs it.
struct ReducedLook {
  Triple antenna_m{};
  Triple velocity_mps{};
};

/// How far a real pair may be from the paper's: parallel tracks, equal heights, no squint.
struct ReductionLimits {
  double max_convergence_rad = 0.17;  ///< angle of the tracks (10 deg: cosine off by 1.5 percent)
  double max_squint_rad = 0.17;       ///< of each look, against the mean track
  double max_height_ratio_1 = 0.1;    ///< |H' - H''| / mean H
};

/// Reduces a pair of looks at a point to the paper's B, H, y.
///
/// Along is the mean track (a pass flown the other way is turned), up the local vertical at the
/// point made orthogonal to it, across = up x along. H is the mean height of the antennas above
/// the point's tangent plane, y the point's across distance from antenna ', B that of antenna ''
/// from antenna '. On an ellipsoid the look angles so become incidence angles at the point, which
/// is what its errors depend on. In the paper's frame the reduction returns B, H and y themselves.
///
/// Empty where the paper has no counterpart: tracks that converge, looks that are squinted or
/// heights that differ by more than the limits, a point above an antenna, a base below 1e-9 H, or
/// a point below an antenna. Antennas on different sides give the opposite-side arrangement.
[[nodiscard]] std::optional<StereoConfiguration> ReducePair(const Triple& point_m,
                                                            const Triple& up_1,
                                                            const ReducedLook& first,
                                                            const ReducedLook& second,
                                                            const ReductionLimits& limits = {});

}  // namespace sarblock::leberl
