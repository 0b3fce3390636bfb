// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path.h"
#include "sarblock/flight/path_through.h"

#include <vector>

namespace sarblock {

/// More states of the same orbit, so that the cubic of FlightPath follows it: every interval is cut
/// into equal parts of at most `step_s`. With states of a low Earth orbit 10 s apart that cubic is
/// 0.2 mm off in position and 7e-5 m/s in velocity (9 mm in the Doppler equation); with parts of 1
/// s it is off by less than the digits the states are given with. The polynomial uses the states
/// around the interval, fewer where the orbit has fewer (docs/theory/flight_path.md, eq.
/// (14)-(15)). The given states stay as they are (kPositions: their positions). Throws InputError
/// unless there are two states or more with increasing times and step_s > 0.
[[nodiscard]] std::vector<StateVector> ResampleOrbit(const std::vector<StateVector>& states,
                                                     double step_s,
                                                     OrbitThrough through);

/// How far velocities and positions contradict each other: largest length of the difference between
/// a given velocity and the derivative of the polynomial through the positions around it [m/s].
/// Only states with four others on both sides count, where the polynomial is accurate to 1e-4 m/s
/// for states 10 s apart in a low orbit; 0 where there is none.
[[nodiscard]] double VelocityContradiction_mps(const std::vector<StateVector>& states);

}  // namespace sarblock
