// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/flight/path_through.h"

#include <cstddef>
#include <span>
#include <vector>

namespace sarblock {

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
  /// What noise of the sigmas leaves in the path, one axis, root mean square over the strip.
  StateNoise remaining;
  /// By how much the velocity of a spline with half the knot spacing differs beyond its noise, root
  /// mean square over the strip, one axis: what the knots do not follow.
  double unfollowed_mps = 0.0;
};

/// Weighted least squares of a cubic spline with continuous acceleration to positions and
/// velocities of a recording (docs/theory/flight_path.md, eqs. (16) to (19)):
///
///     sum |s(t_k) - p_k|^2/sigma_p^2 + |s'(t_k) - v_k|^2/sigma_v^2 -> min
///
/// Knots stand at states, as nearly equally spaced in time as these allow; how many is chosen by
/// generalised cross validation over numbers that grow by the square root of two. Sigmas that are
/// NaN are estimated from the states: first from their differences, then from the residuals.
/// `strip_s` is where `remaining` and `unfollowed_mps` are taken.
/// Cost: linear in the states, some twenty passes over them. The states must be those of a
/// FlightPath.
[[nodiscard]] SmoothedPath SmoothPath(std::span<const StateVector> states,
                                      const StateNoise& sigmas,
                                      const TimeSpan& strip_s);

}  // namespace sarblock
