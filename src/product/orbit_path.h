// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <optional>
#include <string>
#include <vector>

#include "product/orbit_state.h"

namespace sarblock {

/// What is wrong with a state that follows another one (null: the first), as the rest of a sentence
/// that begins with its place: times that do not increase and states that no satellite has. Nothing
/// where it is good.
[[nodiscard]] std::optional<std::string> ProblemOfState(const OrbitState* before,
                                                        const OrbitState& state);

/// States with times from `epoch`.
[[nodiscard]] std::vector<StateVector> StatesFrom(const std::vector<OrbitState>& states,
                                                  const UtcTime& epoch);

/// The path through the states of an orbit, with a state every `step_s` (0: as given). States more
/// than five minutes apart are refused; velocities that contradict the motion of the positions are
/// a warning. `file` is for messages.
[[nodiscard]] FlightPath PathThroughOrbit(const std::string& file,
                                          const std::vector<StateVector>& states,
                                          double step_s,
                                          OrbitThrough through,
                                          std::vector<std::string>* warnings);

}  // namespace sarblock
