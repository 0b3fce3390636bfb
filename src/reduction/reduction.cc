// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/reduction/reduction.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/text.h"

namespace sarblock {
namespace {

constexpr double kLowest_m = -1000.0;  // no ground lies lower

// Jehle et al. (2008). The polynomial has its least value at 12.5 km: it is left where it falls as
// steeply for its value as air does.
double Polynomial_m(double height_m) {
  return height_m * height_m / 8.55e7 - height_m / 3411.0 + 2.41;
}
constexpr double kPolynomialTop_m = 6000.0;

// The standard atmosphere, ISO 2533.
constexpr double kLapse_k_per_m = 0.0065;
constexpr double kTropopause_m = 11000.0;
constexpr double kGravityOverGas_k_per_m = 9.80665 / 287.05287;

// WMO-No. 8 (2008), annex 4.B.
double SaturationPressure_hpa(double temperature_k) {
  const double celsius = temperature_k - 273.15;
  return 6.112 * std::exp(17.62 * celsius / (243.12 + celsius));
}

Weather CarriedTo(double height_m, const Weather& weather) {
  // Through the troposphere and what is above it, up or down.
  Weather carried = weather;
  const double layer_m =
      std::min(height_m, kTropopause_m) - std::min(weather.height_m, kTropopause_m);
  carried.temperature_k -= kLapse_k_per_m * layer_m;
  const double isothermal_m =
      std::max(height_m, kTropopause_m) - std::max(weather.height_m, kTropopause_m);
  const double top_k = std::min(carried.temperature_k, weather.temperature_k);
  carried.pressure_hpa *= std::pow(carried.temperature_k / weather.temperature_k,
                                   kGravityOverGas_k_per_m / kLapse_k_per_m) *
                          std::exp(-kGravityOverGas_k_per_m * isothermal_m / top_k);
  carried.height_m = height_m;
  return carried;
}

void RequireWithin(const char* field, double value, double least, double most, const char* unit) {
  if (value >= least && value <= most) return;
  throw InputError(field,
                   "must be between " + NumberText(least) + " and " + NumberText(most) + unit +
                       ", got " + NumberText(value));
}

}  // namespace

void Validate(const Weather& weather) {
  RequireWithin("pressure_hpa", weather.pressure_hpa, 200.0, 1100.0, " hPa");
  RequireWithin("temperature_k", weather.temperature_k, 180.0, 340.0, " K");
  RequireWithin("humidity_1", weather.humidity, 0.0, 1.0, "");
  RequireWithin("height_m", weather.height_m, kLowest_m, 12000.0, " m");
}

void Validate(const Ionosphere& ionosphere) {
  RequireWithin("tec_tecu", ionosphere.tec_tecu, 0.0, 1000.0, " TECU (1e16 electrons a m2)");
  RequireWithin("share_1", ionosphere.share, 0.0, 1.0, "");
}

double ZenithDelay_m(double height_m) {
  height_m = std::max(height_m, kLowest_m);
  if (height_m <= kPolynomialTop_m) return Polynomial_m(height_m);
  const double top_m = Polynomial_m(kPolynomialTop_m);
  const double slope = 2.0 * kPolynomialTop_m / 8.55e7 - 1.0 / 3411.0;
  return top_m * std::exp(slope / top_m * (height_m - kPolynomialTop_m));
}

double ZenithDelay_m(const Weather& weather, double lat_rad, double height_m) {
  Validate(weather);
  const Weather there = CarriedTo(std::max(height_m, kLowest_m), weather);
  // Vapour of mean lapse: e falls as the pressure to the power of lambda + 1, lambda 2.8 (UNB3m, up
  // to 45 degrees of latitude).
  const double vapour_hpa = weather.humidity * SaturationPressure_hpa(weather.temperature_k) *
                            std::pow(there.pressure_hpa / weather.pressure_hpa, 3.8);
  const double gravity = 1.0 - 0.00266 * std::cos(2.0 * lat_rad) - 2.8e-7 * there.height_m;
  return 0.0022768 *
         (there.pressure_hpa / gravity + (1255.0 / there.temperature_k + 0.05) * vapour_hpa);
}

double IonosphericDelay_m(const Ionosphere& ionosphere, double wavelength_m, double zenith_rad) {
  Validate(ionosphere);
  constexpr double kElectron_m3_per_s2 = 40.308;  // e^2 / (8 pi^2 eps0 m_e), CODATA 2018
  constexpr double kPerTecu = 1e16;
  constexpr double kEarth_m = 6371000.0, kShell_m = 450000.0;
  const double frequency_hz = kSpeedOfLight_mps / wavelength_m;
  const double sine = kEarth_m / (kEarth_m + kShell_m) * std::sin(zenith_rad);
  return kElectron_m3_per_s2 * kPerTecu * ionosphere.tec_tecu * ionosphere.share /
         (frequency_hz * frequency_hz) / std::sqrt(1.0 - sine * sine);
}

}  // namespace sarblock
