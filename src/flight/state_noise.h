// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/flight/path_through.h"

#include <span>

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

}  // namespace sarblock
