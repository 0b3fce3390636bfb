// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"

#include <array>
#include <span>

#include <Eigen/Core>

namespace sarblock::internal {

/// The circle one look confines its point to: where its range sphere and its cone meet
/// (docs/theory/intersection.md, eq. (1)). Coordinates relative to the caller's origin.
struct Circle {
  Eigen::Vector3d antenna_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit flight direction
  double radius_m = 0.0;
  double range_m = 0.0;
  double along_m = 0.0;  ///< R sin(tau): the centre's distance from the antenna along the axis

  [[nodiscard]] static Circle From(const FixedPathLook& observation,
                                   const Eigen::Vector3d& origin_m);
};

/// Orthonormal pair in the plane of a circle, so that points are c + r (e1 cos phi + e2 sin phi).
struct CircleBasis {
  Eigen::Vector3d e1 = Eigen::Vector3d::UnitY();
  Eigen::Vector3d e2 = Eigen::Vector3d::UnitZ();
  [[nodiscard]] static CircleBasis From(const Circle& circle);
};

[[nodiscard]] Eigen::Vector3d PointOn(const Circle& circle,
                                      const CircleBasis& basis,
                                      double phi_rad);

/// Roots of A cos(phi) + B sin(phi) = C: `middle_rad` -+ `half_rad`. Where |C| exceeds the
/// amplitude there is none; then `half_rad` is 0 or pi, the closest approach.
struct CosineRoots {
  double middle_rad = 0.0;
  double half_rad = 0.0;
};
[[nodiscard]] CosineRoots SolveCosine(double a, double b, double c);

/// Closed starts, relative to the origin: two mirror solutions (about the closest approach where
/// the circles do not quite meet), or one point where they are concentric.
struct Starts {
  std::array<Eigen::Vector3d, 2> point_m = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::size_t count = 0;
};

/// Starts from the pair of looks that intersects best: all pairs up to 8 looks, beyond that the
/// best partner of the first look and the best partner of that one. `up` is the vertical at the
/// first antenna; it only places the start where the circles of the pair are concentric.
[[nodiscard]] Starts ClosedStarts(std::span<const FixedPathLook> observations,
                                  const Eigen::Vector3d& origin_m,
                                  const Eigen::Vector3d& up);

/// True where every circle runs within the looks' noise of the first one, all the way round.
[[nodiscard]] bool CirclesCoincide(std::span<const FixedPathLook> observations,
                                   const Eigen::Vector3d& origin_m);

/// The point of one look's circle at a height above the reference surface, on the look side.
[[nodiscard]] Intersection CircleAtHeight(const FixedPathLook& observation,
                                          const Frame& frame,
                                          double height_m);

}  // namespace sarblock::internal
