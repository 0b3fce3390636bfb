// SPDX-License-Identifier: Apache-2.0
#include "stability_recordings.h"

namespace sarblock {
namespace {

/// The aircraft's flight, recorded ten times a second.
StabilityPlan RecordedAircraft(PathThrough through) {
  StabilityPlan plan = AircraftPlan();
  plan.states = 401;
  plan.recording.emplace();
  plan.recording->recorder.rate_hz = 10.0;
  plan.recording->recorder.reading.through = through;
  return plan;
}

/// An orbit with four states and more beyond either end of the strip, as interpolation of degree 7
/// needs them.
StabilityPlan RecordedOrbit(double interval_s) {
  StabilityPlan plan = OrbitPlan();
  plan.states = 2001;
  plan.time_margin_s = 4.5 * interval_s;
  plan.recording.emplace();
  plan.recording->recorder.rate_hz = 1.0 / interval_s;
  plan.recording->recorder.reading.through = PathThrough::kAuto;
  return plan;
}

}  // namespace

const std::vector<PlannedFamily>& RecordingFamilies() {
  static const std::vector<PlannedFamily> kFamilies = {
      {"state-noise",
       "noise_m",
       "noise of the positions recorded at 10 Hz, paths through the states",
       With(0.0, Ratios(1e-7, 1.0, 15)),
       [](double v) {
         StabilityPlan plan = RecordedAircraft(PathThrough::kStates);
         plan.recording->recorder.noise_m = v;
         return plan;
       }},
      {"state-noise-smoothed",
       "noise_m",
       "the same and of velocities, paths smoothed where the data ask for it",
       With(0.0, Ratios(1e-7, 10.0, 17)),
       [](double v) {
         StabilityPlan plan = RecordedAircraft(PathThrough::kAuto);
         plan.recording->recorder.noise_m = v;
         plan.recording->recorder.noise_mps = 0.5 * v;
         return plan;
       }},
      {"wander",
       "rms_m",
       "flights of turbulent air, recorded with 2 cm and 1 cm/s",
       Ratios(1e-3, 1e3, 13),
       [](double v) {
         StabilityPlan plan = RecordedAircraft(PathThrough::kAuto);
         plan.recording->recorder.noise_m = 0.02;
         plan.recording->recorder.noise_mps = 0.01;
         plan.recording->wander.rms_m.fill(v);
         plan.recording->wander.time_constant_s.fill(20.0);
         return plan;
       }},
      {"state-interval",
       "interval_s",
       "orbits whose states stand far apart",
       Ratios(1.0, 600.0, 12),
       [](double v) { return RecordedOrbit(v); }},
      {"velocity-contradiction",
       "bias_mps",
       "orbits whose velocities are not those of their positions, every 10 s",
       With(0.0, Ratios(1e-6, 100.0, 9)),
       [](double v) {
         StabilityPlan plan = RecordedOrbit(10.0);
         plan.recording->recorder.velocity_bias_sigma_mps.fill(v);
         return plan;
       }},
  };
  return kFamilies;
}

}  // namespace sarblock
