// SPDX-License-Identifier: Apache-2.0
#include "orbit_path.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/path.h"

#include "geometry/smooth_path.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

/// Above it positions and velocities tell two stories: 1 mm/s of 7500 m/s turns the Doppler plane
/// by 0.1 m at 900 km.
constexpr double kContradiction_mps = 1e-3;

// States 5 minutes apart leave the polynomial of degree 7 some 6 mm from a low orbit; farther ones
// no longer tell where the satellite was.
void RefuseGaps(const std::string& file, const std::vector<StateVector>& states) {
  constexpr double kLongest_s = 300.0;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double gap_s = states[k].time_s - states[k - 1].time_s;
    if (gap_s <= kLongest_s) continue;
    throw InputError(FilePlace{file, 0, "orbit"},
                     fmt::format("states {} and {} are {} s apart, {} s at most is allowed",
                                 k,
                                 k + 1,
                                 gap_s,
                                 kLongest_s));
  }
}

}  // namespace

std::optional<std::string> ProblemOfState(const OrbitState* before, const OrbitState& state) {
  if (before != nullptr && !(SecondsBetween(before->time, state.time) > 0.0)) {
    return "its time " + UtcText(state.time) + " is not after that of the state before, " +
           UtcText(before->time);
  }
  // The Earth's polar radius is 6357 km; states in kilometres or in wrong columns show here.
  constexpr double kLowest_m = 6.36e6;
  if (!(state.position_m.norm() > kLowest_m)) {
    return "the position lies inside the Earth, metres in earth-fixed axes are needed";
  }
  if (!(state.velocity_mps.norm() > 0.0)) return "the velocity is zero";
  return std::nullopt;
}

std::vector<StateVector> StatesFrom(const std::vector<OrbitState>& states, const UtcTime& epoch) {
  std::vector<StateVector> result;
  result.reserve(states.size());
  for (const OrbitState& state : states) {
    result.push_back({SecondsBetween(epoch, state.time), state.position_m, state.velocity_mps});
  }
  return result;
}

FlightPath PathThroughOrbit(const std::string& file,
                            const std::vector<StateVector>& states,
                            double step_s,
                            OrbitThrough through,
                            std::vector<std::string>* warnings) {
  RefuseGaps(file, states);
  const double contradiction_mps = LargestContradiction_mps(states);
  if (through == OrbitThrough::kStates && contradiction_mps > kContradiction_mps) {
    warnings->push_back(
        fmt::format("{}: velocities of the orbit differ from the motion of its positions by up "
                    "to {:.4f} m/s; "
                    "the path swings between the states, --orbit-through positions avoids it",
                    file,
                    contradiction_mps));
  }
  if (step_s == 0.0) return FlightPath(states);
  return FlightPath(ResampleOrbit(states, step_s, through));
}

}  // namespace sarblock
