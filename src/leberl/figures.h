// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/look_equations.h"
#include "sarblock/leberl/formulas.h"

#include <optional>
#include <string>
#include <vector>

#include "pair.h"

namespace sarblock {

/// The configurations of Leberl (1979), Fig. 3 to 5, 8 and 9, at one point of the ground, beside
/// each other. The point is (0, y, 0) in the paper's frame; its covariance is that of the rigorous
/// intersection (geometry::Intersect) with the flight paths held fixed.
///
///   - 3, 4 same side: stations at 0 and B, both H high
///   - 3, 4 opposite side: at 0 and beyond the point, at the look angle of the second station
///   - 3, 4 cross-wise: at 0, and across the first one's track at the same distance y
///   - 3, 4 two heights: at 0, 0.6 H and 1.2 H high
///   - 3, 4 convergent: at 0 and B, squinted by 20 and -20 degrees
///   - 5 single flight: one straight line, squinted by 15 and -15 degrees
///   - 5 single orbit: the same squints from a circular orbit 700 km above the Earth, look 45
///   degrees
///   - 8, 9 Apollo radar: 116 km above the Moon, bases of 3 and 13 km, looks of 14 to 20 degrees
struct FigureOptions {
  /// B, H and y of the first five; the aircraft of Table 1 in the middle of its model.
  leberl::StereoConfiguration ground{.base_m = 8e3, .height_m = 10e3, .ground_range_m = 19e3};
  double sigma_range_m = 1.0;
  double sigma_azimuth_m = 1.0;  ///< along track at the target
};

/// A configuration and what it gives.
struct FigureRow {
  std::string figure;  ///< "3, 4"
  std::string name;
  std::optional<double> base_m;  ///< distance of the tracks across; empty for crossing ones
  double first_look_rad = 0.0;   ///< off nadir, in the plane normal to the track
  double second_look_rad = 0.0;
  double intersection_rad = 0.0;  ///< dtheta, sarblock::IntersectionAngle
  /// Standard deviations of the point along and across the first track and up; empty where the
  /// circles of both looks do not determine it.
  std::optional<PointSigmas> sigmas;
  std::optional<double> exaggeration;  ///< q of Eq. 10; empty where no parallax can be viewed
  IntersectionOutcome outcome = IntersectionOutcome::kNotConverged;
};

/// Throws InputError naming the value unless `ground` is a same-side configuration and both
/// standard deviations are finite and positive.
[[nodiscard]] std::vector<FigureRow> PaperFigures(const FigureOptions& options);

}  // namespace sarblock
