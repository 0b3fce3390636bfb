// SPDX-License-Identifier: Apache-2.0
#include "paper/single_flight.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"

#include <array>
#include <cmath>
#include <numbers>

#include "linear/dense.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr double kRankTolerance = 1e-10;  // rows have length near 1; rounding is 1e-15

void Validate(const SingleFlightPair& pair) {
  if (!(std::isfinite(pair.height_m) && pair.height_m > 0.0)) {
    throw InputError("height_m", fmt::format("{} is given, > 0 is allowed", pair.height_m));
  }
  if (!std::isfinite(pair.ground_range_m) || pair.ground_range_m == 0.0) {
    throw InputError("ground_range_m", "the point must not lie below the flight line");
  }
  for (const double squint_rad : {pair.first_squint_rad, pair.second_squint_rad}) {
    if (!(std::abs(squint_rad) < 0.5 * std::numbers::pi)) {
      throw InputError("squint_rad",
                       fmt::format("{} is given, (-pi/2, pi/2) is allowed", squint_rad));
    }
  }
  if (pair.first_squint_rad == pair.second_squint_rad) {
    throw InputError("second_squint_rad", "both looks have the same squint: it is one look");
  }
}

}  // namespace

SingleFlightProof ProveSingleFlight(const SingleFlightPair& pair) {
  Validate(pair);
  const Eigen::Vector3d velocity_mps(1.0, 0.0, 0.0);
  const Eigen::Vector3d point_m(0.0, pair.ground_range_m, 0.0);
  const double radius_m = std::hypot(pair.ground_range_m, pair.height_m);
  std::array<Sight, 2> sights;
  Eigen::Matrix<double, 4, 3> jacobian;
  std::array<double, 2> plane_m{}, circle_m{};
  for (std::size_t k = 0; k < 2; ++k) {
    const double squint_rad = k == 0 ? pair.first_squint_rad : pair.second_squint_rad;
    Sight& sight = sights[k];
    sight.antenna_m = Eigen::Vector3d(-radius_m * std::tan(squint_rad), 0.0, pair.height_m);
    sight.velocity_mps = velocity_mps;
    sight.range_m = (point_m - sight.antenna_m).norm();
    sight.cone.squint_rad = squint_rad;
    sight.side = pair.ground_range_m > 0.0 ? +1 : -1;
    plane_m[k] = sight.antenna_m.x() + sight.range_m * std::sin(squint_rad);
    circle_m[k] = sight.range_m * std::cos(squint_rad);
    LookEquations equations;
    if (!EvaluateLookEquations(
            point_m, sight.antenna_m, velocity_mps, sight.cone, 0.0, &equations)) {
      throw InputError("squint_rad", "the look equations have no value for this squint");
    }
    const auto row = static_cast<Eigen::Index>(2 * k);
    jacobian.row(row) = equations.drho_dp;
    jacobian.row(row + 1) = equations.ded_dp;
  }
  SingleFlightProof proof;
  const Eigen::Vector3d singular = dense::DecomposeSingular(jacobian).values;
  for (int i = 0; i < 3; ++i) {
    proof.singular_1[i] = singular(i);
    if (singular(i) > kRankTolerance) ++proof.rank;
  }
  proof.plane_gap_m = std::abs(plane_m[0] - plane_m[1]);
  proof.radius_gap_m = std::abs(circle_m[0] - circle_m[1]);
  proof.outcome = Intersect(sights, Frame::Local()).outcome;
  proof.reason = fmt::format(
      "both looks confine the point to the same circle of radius {:.6g} m normal to the flight "
      "line: {} of 3 coordinates are determined, there is no parallax from one flight line",
      circle_m[0],
      proof.rank);
  return proof;
}

}  // namespace sarblock
