// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/parallax.h"
#include "sarblock/leberl/point_errors.h"
#include "sarblock/leberl/relative_errors.h"

#include <optional>

namespace sarblock {

// Rigorous counterparts of Leberl (1979), Eq. 6-8 and 12-25: nothing here uses a closed form of
// the paper, only the range spheres and Doppler planes (Eq. 1-4). They share the paper's types.
//
// What is computed: the true point (0, y, z) gives the true slant ranges and zero Doppler. The
// reconstruction takes antenna positions, velocity directions and ranges with errors added (used
// minus true) and solves |p - s'| = r', |p - s''| = r'', u'.(p - s') = 0, u''.(p - s'') = 0 for p
// by least squares with equal weights, u the unit vector along (1, dydot0, dzdot0). The result is
// reconstructed minus true. Equal weights make dx the mean of the two planes, as Eq. 13 has it.
// 64-bit mantissa throughout. docs/theory/leberl.md, section 2.

/// First order: the derivative of the intersection in the direction of `errors`, by the implicit
/// function theorem, dp = -(J'J)^-1 J'E e. Accuracy: 1e-12 relative for dtheta > 0.1 degree.
/// `terrain_height_m` is the z of the point, below the stations.
[[nodiscard]] leberl::PointError StereoErrorDerivative(const leberl::StereoConfiguration& c,
                                                       const leberl::StereoErrors& errors,
                                                       double terrain_height_m = 0.0);

/// Finite size: the intersection itself. Empty where the perturbed circles have no intersection
/// (they do not meet, or meet on the other side of their common tangent).
[[nodiscard]] std::optional<leberl::PointError> StereoErrorExact(
    const leberl::StereoConfiguration& c,
    const leberl::StereoErrors& errors,
    double terrain_height_m = 0.0);

/// First-order error of a coordinate difference: the derivative of StereoErrorDerivative along
/// (Dy, Dz) at (y, 0), times that difference. Counterpart of Eq. 18, 19, 22-24.
[[nodiscard]] leberl::PointError DifferenceErrorDerivative(const leberl::StereoConfiguration& c,
                                                           const leberl::StereoErrors& errors,
                                                           const leberl::Difference& difference);

/// Error of the difference between the points (y + Dy, Dz) and (y, 0), both finite. Empty where
/// one of them has no intersection.
[[nodiscard]] std::optional<leberl::PointError> DifferenceErrorExact(
    const leberl::StereoConfiguration& c,
    const leberl::StereoErrors& errors,
    const leberl::Difference& difference);

/// Covariance of the two-look intersection (geometry::Intersect) by range noise, paths held.
/// Counterpart of Eq. 25. Throws UndeterminedError where the looks do not determine the point.
[[nodiscard]] leberl::RangeNoise StereoRangeNoise(const leberl::StereoConfiguration& c,
                                                  double range_sigma_m);

/// Spherical wave fronts: parallax difference between the points (y, h) and (y, 0), each image's
/// displacement counted towards its antenna, second -/+ first as in Eq. 6 and 7 [m]. Empty where
/// the point is closer to an antenna than the datum (no ground range).
[[nodiscard]] std::optional<double> ExactParallaxFromHeight(const leberl::StereoConfiguration& c,
                                                            double height_m,
                                                            leberl::Presentation presentation);

/// Inverse of ExactParallaxFromHeight by Newton's method; empty where it finds no height.
[[nodiscard]] std::optional<double> ExactHeightFromParallax(const leberl::StereoConfiguration& c,
                                                            double parallax_m,
                                                            leberl::Presentation presentation);

}  // namespace sarblock
