// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"

#include <span>

#include <Eigen/Core>

namespace sarblock {

/// Point where the range spheres and Doppler cones of two or more looks meet, least squares over
/// all of them, with the covariance from the looks' standard deviations (flight paths fixed).
/// Closed start from the pair that intersects best, then Newton with damping. Among mirror
/// solutions the look side decides, then the one below the antennas.
///
/// A point is not determined (touching, coinciding) if its Jacobian is singular by the option, if
/// its standard deviation exceeds half the shortest range, or if its equations are so nonlinear
/// within one standard deviation that the mirror solution is as likely. kCirclesDoNotMeet: v'Pv
/// beyond its chi-square quantile at 1 - 1e-6 for 2n - 3 degrees of freedom. Except for
/// kTooFewLooks the position is the best point found for any outcome: usable as a start value, not
/// as a result. The covariance is zero where the point is not determined.
/// Throws InputError for a value that is not finite, a range, speed or standard deviation that is
/// not positive, a side other than +1 or -1, a squint or Doppler centroid beyond the flight axis.
/// Leberl (1979), Eq. 1-4; docs/theory/intersection.md.
[[nodiscard]] Intersection Intersect(std::span<const FixedPathLook> observations,
                                     const Frame& frame,
                                     const IntersectionOptions& options = {});

/// Point of one look on the reference surface at `height_m` (local: z = height), on the look side.
/// kDetermined or kCirclesDoNotMeet (circle above or below the surface). No covariance. Within
/// 1e-9 m of the surface for aircraft, 1e-8 m from orbit. Throws InputError as Intersect does.
[[nodiscard]] Intersection IntersectWithHeight(const FixedPathLook& observation,
                                               const Frame& frame,
                                               double height_m);

/// Angle at p between the lines of sight of two looks, each projected on the plane normal to its
/// own flight direction: Leberl's dtheta for parallel tracks (squinted ones too), the angle of the
/// two range gradients for zero-Doppler looks of any tracks. In [0, pi].
[[nodiscard]] double IntersectionAngle(const Eigen::Vector3d& p_m,
                                       const FixedPathLook& a,
                                       const FixedPathLook& b);

/// Largest IntersectionAngle over pairs of looks; above 16 looks over those with the first look and
/// with the one farthest from it. 0 below two looks.
[[nodiscard]] double LargestIntersectionAngle(const Eigen::Vector3d& p_m,
                                              std::span<const FixedPathLook> observations);

}  // namespace sarblock
