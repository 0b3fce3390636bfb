// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// What the recording of a flight does to the points of a pass: errors of its path along track at
/// the target, root mean square over the strip at the largest range, beside the standard deviation
/// of azimuth. An error of the velocity across the flight turns the Doppler cone: dv R/|v|.
/// docs/theory/flight_path.md#recorded-flights.
struct RecordingEffect {
  PathThrough through = PathThrough::kStates;  ///< how the path was made; not kAuto
  double noise_m = 0.0;                        ///< by noise of the states
  double contradiction_m = 0.0;  ///< by velocities that are not those of the positions
  double interpolation_m = 0.0;  ///< by what the path between states cannot follow
  /// Mean of the looks; NaN where no look gives a range and one.
  double azimuth_sigma_m = std::numeric_limits<double>::quiet_NaN();
  StateNoise noise{0.0, 0.0};      ///< of the states, as given or estimated
  std::optional<FitOfStates> fit;  ///< of a smoothed path
  std::string why;                 ///< of kAuto: what was taken and why; else empty

  [[nodiscard]] double Total_m() const {
    return std::hypot(noise_m, contradiction_m, interpolation_m);
  }
  /// From a tenth of sigma on a recording is warned of: it adds 0.5 % to the sigma of one look, but
  /// looks near each other share it.
  [[nodiscard]] bool Matters() const { return Total_m() > 0.1 * azimuth_sigma_m; }
};

/// How the flight of a pass was recorded and read.
struct RecordedFlight {
  TrajectoryOptions asked;
  std::vector<StateVector> states;  ///< as recorded; empty: the states of the path
  RecordingEffect effect;
};

}  // namespace sarblock
