// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/geometry/look_equations.h"

#include <cmath>
#include <optional>

#include <Eigen/Core>

namespace sarblock {

/// e_d of a look at fixed point as its time moves, and how fast it falls.
struct ConeValue {
  double doppler_error_m = 0.0;
  double rate_mps = 0.0;  ///< de_d/dt, about -|v| cos^2(tau)
};
[[nodiscard]] ConeValue EvaluateCone(const Motion& motion,
                                     const Eigen::Vector3d& p_m,
                                     const Cone& cone);

/// The explicit observation model's time: Newton's method on e_d(t) = 0 from `time_s` over any path
/// with At(t) -> optional<Motion>. Converges to the rounding of e_d (below 10 nm for |p| < 1e7 m);
/// nothing where an iterate leaves the path or 30 steps do not suffice.
template <typename Path>
[[nodiscard]] std::optional<double> SolveConeTime(const Path& path,
                                                  const Eigen::Vector3d& p_m,
                                                  const Cone& cone,
                                                  double time_s) {
  constexpr double kCloseEnough_m = 1e-7;  // one more step then reaches the rounding
  for (int iteration = 0; iteration < 30; ++iteration) {
    const std::optional<Motion> motion = path.At(time_s);
    if (!motion) return std::nullopt;
    const ConeValue at = EvaluateCone(*motion, p_m, cone);
    if (!(at.rate_mps < 0.0)) return std::nullopt;  // beyond the cone's turning point, or NaN
    time_s -= at.doppler_error_m / at.rate_mps;
    if (std::abs(at.doppler_error_m) < kCloseEnough_m) return time_s;
  }
  return std::nullopt;
}

/// The time in [start_s, end_s] at which p lies on the cone, or nothing: sign change between the
/// ends, then Newton kept inside the bracket by bisection.
[[nodiscard]] std::optional<double> FindConeTime(const FlightPath& path,
                                                 const Eigen::Vector3d& p_m,
                                                 const Cone& cone,
                                                 double start_s,
                                                 double end_s);

}  // namespace sarblock
