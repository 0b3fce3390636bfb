// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

namespace sarblock {

/// What an orbit is interpolated through between its state vectors.
enum class OrbitThrough {
  kStates,     ///< positions and velocities: Hermite polynomial of degree 7 through four states
  kPositions,  ///< positions alone: Lagrange polynomial of degree 7 through eight; velocities are
               ///< its derivative. For states whose velocities contradict their positions.
};

/// What a flight path goes through between the states of a recording
/// (docs/theory/flight_path.md#recorded-flights).
enum class PathThrough : std::uint8_t {
  kStates,     ///< the cubic of two states: positions and velocities
  kOrbit,      ///< polynomials of degree 7 through four states: positions and velocities
  kPositions,  ///< polynomials of degree 7 through the positions of eight states
  kSmooth,     ///< a spline with continuous acceleration, fitted by least squares
  kAuto,       ///< the first of these that the data bear
};
[[nodiscard]] const char* NameOf(PathThrough through);  ///< "states", "orbit", ...

/// White noise of states, one axis. NaN: not known.
struct StateNoise {
  double position_m = std::numeric_limits<double>::quiet_NaN();
  double velocity_mps = std::numeric_limits<double>::quiet_NaN();
};

/// How a recording is to be read.
struct TrajectoryOptions {
  PathThrough through = PathThrough::kStates;
  StateNoise sigma;  ///< standard deviations of the states; NaN: estimated from them
};

struct TimeSpan {
  double first_s = 0.0, last_s = 0.0;
};

/// How well the states of a smoothed path fit their standard deviations: sum of squares over their
/// variances by degrees of freedom, 1 where they are as stated.
struct FitOfStates {
  double position_1 = 1.0, position_freedom = 0.0;
  double velocity_1 = 1.0, velocity_freedom = 0.0;
};

}  // namespace sarblock
