// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>

#include "wander.h"

namespace sarblock {

/// The motion of a flight at `time_s`: f = p + A w, A the track axes of the planned path p. Nothing
/// outside the planned path; `wander` null: the planned motion. The jerk lacks A''' w.
[[nodiscard]] std::optional<Motion> FlownMotion(const Frame& frame,
                                                const FlightPath& planned,
                                                const Wander* wander,
                                                double time_s);

/// The path that the recorder writes: states of the flown motion at start_s + k spacing of the
/// strip, whole k, as far as the planned path reaches, with the recorder's errors drawn from
/// streams of pass and state.
[[nodiscard]] FlightPath RecordFlight(const Frame& frame,
                                      const SceneRecorder& recorder,
                                      double spacing_s,
                                      const Pass& planned,
                                      const Wander* wander,
                                      std::size_t pass_index,
                                      std::uint64_t seed);

}  // namespace sarblock
