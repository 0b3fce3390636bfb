// SPDX-License-Identifier: Apache-2.0
#include "ephemeris_time.h"

#include <cmath>
#include <cstdint>

namespace sarblock {
namespace {

constexpr std::int64_t kNoonOf2000 = 946'728'000;  // 2000-01-01T12:00:00 from 1970-01-01
constexpr double kTerrestrialMinusTai_s = 32.184;

double BarycentricMinusTerrestrial_s(double terrestrial_s) {
  constexpr double kAmplitude_s = 1.657e-3, kEccentricity = 1.671e-2;
  constexpr double kAnomaly_rad = 6.239996, kAnomalyRate_rad_per_s = 1.99096871e-7;
  const double mean_rad = kAnomaly_rad + kAnomalyRate_rad_per_s * terrestrial_s;
  return kAmplitude_s * std::sin(mean_rad + kEccentricity * std::sin(mean_rad));
}

}  // namespace

double EphemerisTime_s(const UtcTime& time) {
  const double terrestrial_s = static_cast<double>(time.tai_whole - kNoonOf2000) +
                               (time.fraction_s + kTerrestrialMinusTai_s);
  return terrestrial_s + BarycentricMinusTerrestrial_s(terrestrial_s);
}

UtcTime UtcOfEphemerisTime(double ephemeris_time_s) {
  // The difference changes by 3e-10 a second: one step is enough.
  const double terrestrial_s = ephemeris_time_s - BarycentricMinusTerrestrial_s(ephemeris_time_s);
  return AddSeconds({kNoonOf2000, 0.0}, terrestrial_s - kTerrestrialMinusTai_s);
}

}  // namespace sarblock
