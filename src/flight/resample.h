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

}  // namespace sarblock
