// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/model/result.h"

#include <array>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// The horizontal error ellipse of a point: half axes, and the direction of the longer one
/// clockwise from north, in [0, pi).
struct ErrorEllipse {
  double major_m = 0.0;
  double minor_m = 0.0;
  double azimuth_rad = 0.0;
};

/// Eigenvalues and eigenvectors of [[ee, en], [en, nn]] in closed form, times `scale_1`. The
/// standard ellipse (scale 1) holds the true place with probability 1 - exp(-1/2), 39.3 percent.
[[nodiscard]] ErrorEllipse EllipseOf(const SymmetricEnu& covariance_m2, double scale_1 = 1.0);

/// Scale of the ellipse that holds the true place of a normal error with probability
/// 0 < confidence < 1: the root of the chi-square quantile of two degrees of freedom,
///
///     k = sqrt(-2 ln(1 - confidence))
///
/// Throws InputError for other values.
[[nodiscard]] double EllipseScale(double confidence_1);

constexpr int kEllipseCorners = 36;

/// Corners on the ellipse, east and north of its centre, counter-clockwise.
[[nodiscard]] std::array<Eigen::Vector2d, kEllipseCorners> EllipseCorners(
    const ErrorEllipse& ellipse);

/// The corners about p in true size, in the tangent plane of a geocentric frame at p. Longitudes
/// stay within half a turn of that of p, so that a ring across 180 degrees is not torn.
[[nodiscard]] std::array<Geodetic, kEllipseCorners> EllipseRing(const Frame& frame,
                                                                const Eigen::Vector3d& p_m,
                                                                const ErrorEllipse& ellipse);

}  // namespace sarblock
