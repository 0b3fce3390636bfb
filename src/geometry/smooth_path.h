// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <cstddef>
#include <span>
#include <vector>

namespace sarblock {

/// White noise of positions and of velocities, each from the differences of order 3 to 10 scaled to
/// unit noise (docs/theory/flight_path.md, eq. (20)): the first of their root mean squares that is
/// not significantly above the least, 0 where the last two still fall to 0.7 or less each, and
/// where there are too few states. At most 256 windows of states are read, evenly spaced.
[[nodiscard]] StateNoise EstimateStateNoise(std::span<const StateVector> states);

/// Velocities less derivatives of the polynomials through nine positions, averaged over sixteenths
/// of the states, across the flight: root mean square without its noise; 0 where it is not
/// significant at a level of 1e-6 and where there are less than nine states (eq. (21)).
[[nodiscard]] double Contradiction_mps(std::span<const StateVector> states,
                                       const StateNoise& noise);

/// The largest of those differences, of any direction and not averaged [m/s]: for states of little
/// noise, such as those of orbits. Accurate to 1e-4 m/s for states 10 s apart in a low orbit; 0
/// where there are less than nine states.
[[nodiscard]] double LargestContradiction_mps(std::span<const StateVector> states);

/// The part of a vector across a velocity.
[[nodiscard]] inline Eigen::Vector3d Across(const Eigen::Vector3d& vector,
                                            const Eigen::Vector3d& velocity) {
  return vector - velocity * (vector.dot(velocity) / velocity.squaredNorm());
}

/// How well states fit a smoothed path: the squares of their residuals over their variances,
/// summed, with the degrees of freedom that belong to them (their part of the redundancy).
struct StateMisfit {
  double chi_square = 0.0;
  double freedom = 0.0;
};

/// A smoothed flight path.
struct SmoothedPath {
  std::vector<StateVector> states;  ///< at the knots; the cubic through them is the spline
  StateNoise sigmas;                ///< of the states: as given, or as estimated
  StateMisfit positions, velocities;
  /// Noise left in the path by states with these sigmas, one axis, root mean square over the strip.
  StateNoise remaining;
  /// What the knots do not follow: the difference of the velocity to that of a spline with half the
  /// knot spacing, beyond its noise, root mean square over the strip, one axis.
  double unfollowed_mps = 0.0;
};

/// The spline of SmoothPath with so many intervals, as its states at the knots; empty where the
/// states do not determine it. Of the sigmas only the ratio counts.
[[nodiscard]] std::vector<StateVector> FitSpline(std::span<const StateVector> states,
                                                 std::size_t intervals,
                                                 const StateNoise& sigmas);

/// Weighted least squares of a cubic spline with continuous acceleration to positions and
/// velocities of a recording (docs/theory/flight_path.md, eqs. (16) to (19)):
///
///     sum |s(t_k) - p_k|^2/sigma_p^2 + |s'(t_k) - v_k|^2/sigma_v^2 -> min
///
/// Knots are at states, as nearly equally spaced in time as these allow; how many is chosen by
/// generalised cross validation over numbers that grow by the square root of two. Sigmas that are
/// NaN are estimated from the states: first from their differences, then from the residuals.
/// `strip_s` is where `remaining` and `unfollowed_mps` are taken.
/// Cost: linear in the states, some twenty passes over them. The states must be those of a
/// FlightPath.
[[nodiscard]] SmoothedPath SmoothPath(std::span<const StateVector> states,
                                      const StateNoise& sigmas,
                                      const TimeSpan& strip_s);

}  // namespace sarblock
