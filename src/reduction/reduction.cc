// SPDX-License-Identifier: Apache-2.0
#include "reduction.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/reduction/reduction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include "core/text.h"
#include <Eigen/Geometry>
#include <erfa.h>
#include <erfam.h>

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

using Eigen::Vector3d;

namespace {

constexpr double kEarthRadius_m = 6378136.6;
// Of Moon and Sun to the Earth: IERS Conventions (2010), table 1.1.
constexpr std::array<double, 2> kMassRatio{0.0123000371, 332946.0482};

// Love and Shida numbers, IERS Conventions (2010), table 7.2 and section 7.1.1.
constexpr double kH2 = 0.6078, kH2OfLatitude = -0.0006;
constexpr double kL2 = 0.0847, kL2OfLatitude = 0.0002;
constexpr double kH3 = 0.292, kL3 = 0.015;
constexpr double kL1Diurnal = 0.0012, kL1Semidiurnal = 0.0024;
constexpr double kHImaginaryDiurnal = -0.0025, kLImaginaryDiurnal = -0.0007;
constexpr double kHImaginarySemidiurnal = -0.0022, kLImaginarySemidiurnal = -0.0007;

// How Love numbers change near a frequency, by the amplitude of its tide: multiples of the Delaunay
// arguments, then in phase and out of phase, radial and transverse [mm].
struct Line {
  std::array<double, 5> multiples;
  double radial_in, radial_out, transverse_in, transverse_out;
};
// IERS Conventions (2010), table 7.3a: all of 0.05 mm and more.
constexpr std::array<Line, 11> kDiurnal{{
    {{1, 0, 2, 0, 2}, -0.08, 0.00, -0.01, 0.01},    // Q1
    {{0, 0, 2, 0, 1}, -0.10, 0.00, 0.00, 0.00},     //
    {{0, 0, 2, 0, 2}, -0.51, 0.00, -0.02, 0.03},    // O1
    {{1, 0, 0, 0, 0}, 0.06, 0.00, 0.00, 0.00},      // NO1
    {{0, 1, 2, -2, 2}, -0.06, 0.00, 0.00, 0.00},    // pi1
    {{0, 0, 2, -2, 2}, -1.23, -0.07, 0.06, 0.01},   // P1
    {{0, 0, 0, 0, -1}, -0.22, 0.01, 0.01, 0.00},    //
    {{0, 0, 0, 0, 0}, 12.00, -0.78, -0.67, -0.03},  // K1
    {{0, 0, 0, 0, 1}, 1.73, -0.12, -0.10, 0.00},    //
    {{0, -1, 0, 0, 0}, -0.50, -0.01, 0.03, 0.00},   // psi1
    {{0, 0, -2, 2, -2}, -0.11, 0.01, 0.01, 0.00},   // phi1
}};
// Table 7.3b.
constexpr std::array<Line, 5> kZonal{{
    {{0, 0, 0, 0, 1}, 0.47, 0.16, 0.23, 0.07},
    {{0, 0, -2, 2, -2}, -0.20, -0.11, -0.12, -0.05},  // Ssa
    {{-1, 0, 0, 0, 0}, -0.11, -0.09, -0.08, -0.04},   // Mm
    {{0, 0, -2, 0, -2}, -0.13, -0.15, -0.11, -0.07},  // Mf
    {{0, 0, -2, 0, -1}, -0.05, -0.06, -0.05, -0.03},
}};

// A place by its geocentric coordinates.
struct Station {
  Vector3d up, east, north;
  double lon_rad, sin_lat, cos_lat;

  explicit Station(const Vector3d& p_m)
      : up(p_m.normalized()), lon_rad(std::atan2(p_m.y(), p_m.x())) {
    sin_lat = up.z();
    cos_lat = std::hypot(up.x(), up.y());
    east = {-std::sin(lon_rad), std::cos(lon_rad), 0.0};
    north = up.cross(east);
  }
  [[nodiscard]] double SinTwice() const { return 2.0 * sin_lat * cos_lat; }
  [[nodiscard]] double CosTwice() const { return cos_lat * cos_lat - sin_lat * sin_lat; }
};

// In time with the potential: equations 7.5 and 7.6.
Vector3d InPhase_m(const Station& at, const Vector3d& body_m, double ratio) {
  const double distance_m = body_m.norm();
  const Vector3d to_body = body_m / distance_m;
  const double nearness = kEarthRadius_m / distance_m;
  const double degree2_m = ratio * kEarthRadius_m * std::pow(nearness, 3);
  const double legendre = 0.5 * (3.0 * at.sin_lat * at.sin_lat - 1.0);
  const double h2 = kH2 + kH2OfLatitude * legendre, l2 = kL2 + kL2OfLatitude * legendre;
  const double c = to_body.dot(at.up);
  const Vector3d level = to_body - c * at.up;
  return degree2_m * (h2 * (1.5 * c * c - 0.5) * at.up + 3.0 * l2 * c * level) +
         degree2_m * nearness *
             (kH3 * (2.5 * c * c - 1.5) * c * at.up + kL3 * (7.5 * c * c - 1.5) * level);
}

// What depends on latitude and lags behind, by bands: equations 7.8 to 7.11.
Vector3d ByBands_m(const Station& at, const Vector3d& body_m, double ratio) {
  const double distance_m = body_m.norm();
  const double degree2_m = ratio * kEarthRadius_m * std::pow(kEarthRadius_m / distance_m, 3);
  const double sin_body = body_m.z() / distance_m;
  const double cos_body = std::hypot(body_m.x(), body_m.y()) / distance_m;
  const double angle_rad = at.lon_rad - std::atan2(body_m.y(), body_m.x());
  const double sin1 = std::sin(angle_rad), cos1 = std::cos(angle_rad);
  const double sin2 = std::sin(2.0 * angle_rad), cos2 = std::cos(2.0 * angle_rad);
  const double p21 = 3.0 * sin_body * cos_body, p22 = 3.0 * cos_body * cos_body;
  const Vector3d diurnal =
      -kL1Diurnal * at.sin_lat * p21 *
          (at.sin_lat * cos1 * at.north - at.CosTwice() * sin1 * at.east) -
      0.5 * kHImaginaryDiurnal * p21 * at.SinTwice() * sin1 * at.up -
      kLImaginaryDiurnal * p21 * (at.CosTwice() * sin1 * at.north + at.sin_lat * cos1 * at.east);
  const Vector3d semidiurnal =
      -0.5 * kL1Semidiurnal * at.sin_lat * at.cos_lat * p22 *
          (cos2 * at.north + at.sin_lat * sin2 * at.east) -
      0.25 * kHImaginarySemidiurnal * p22 * at.cos_lat * at.cos_lat * sin2 * at.up +
      0.25 * kLImaginarySemidiurnal * p22 *
          (at.SinTwice() * sin2 * at.north - 2.0 * at.cos_lat * cos2 * at.east);
  return degree2_m * (diurnal + semidiurnal);
}

double PhaseOf(const Line& line, const std::array<double, 5>& delaunay_rad) {
  double phase_rad = 0.0;
  for (std::size_t k = 0; k < delaunay_rad.size(); ++k) {
    phase_rad -= line.multiples[k] * delaunay_rad[k];
  }
  return phase_rad;
}

// What depends on frequency: equations 7.12 and 7.13.
Vector3d ByFrequencies_m(const Station& at, const TidalBodies& bodies) {
  double up_mm = 0.0, east_mm = 0.0, north_mm = 0.0;
  for (const Line& line : kDiurnal) {
    const double angle_rad =
        bodies.sidereal_rad + std::numbers::pi + at.lon_rad + PhaseOf(line, bodies.delaunay_rad);
    const double sine = std::sin(angle_rad), cosine = std::cos(angle_rad);
    up_mm += (line.radial_in * sine + line.radial_out * cosine) * at.SinTwice();
    east_mm += (line.transverse_in * cosine - line.transverse_out * sine) * at.sin_lat;
    north_mm += (line.transverse_in * sine + line.transverse_out * cosine) * at.CosTwice();
  }
  for (const Line& line : kZonal) {
    const double angle_rad = PhaseOf(line, bodies.delaunay_rad);
    const double sine = std::sin(angle_rad), cosine = std::cos(angle_rad);
    up_mm +=
        (line.radial_in * cosine + line.radial_out * sine) * (1.5 * at.sin_lat * at.sin_lat - 0.5);
    north_mm += (line.transverse_in * cosine + line.transverse_out * sine) * at.SinTwice();
  }
  return 1e-3 * (up_mm * at.up + east_mm * at.east + north_mm * at.north);
}

}  // namespace

TidalBodies TidalBodiesAt(const UtcTime& time) {
  static const UtcTime first = *ParseUtc("1972-01-01T00:00:00");
  // From then on UTC may leave the turning Earth by more than a second (CGPM 2022, resolution 4).
  static const UtcTime end = *ParseUtc("2035-01-01T00:00:00");
  if (SecondsBetween(first, time) < 0.0 || SecondsBetween(time, end) <= 0.0) {
    throw InputError(
        "utc",
        "must be from 1972 to 2034, where leap seconds are known or few, got " + UtcText(time));
  }
  constexpr double kJ2000 = 2451545.0, kDay_s = 86400.0, kDaysPerCentury = 36525.0;
  // TDB for TT (2 ms) and UTC for UT1 (0.9 s) are 0.03 mm.
  const double terrestrial_d = EphemerisTime_s(time) / kDay_s;
  const double universal_d = terrestrial_d - (TaiMinusUtc_s(time) + 32.184) / kDay_s;
  double earth_fixed[3][3], moon[2][3], earth_of_sun[2][3], earth[2][3];
  eraC2t00b(kJ2000, terrestrial_d, kJ2000, universal_d, 0.0, 0.0, earth_fixed);
  eraMoon98(kJ2000, terrestrial_d, moon);
  eraEpv00(kJ2000, terrestrial_d, earth_of_sun, earth);
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const RowMajor turn = Eigen::Map<const RowMajor>(&earth_fixed[0][0]);
  TidalBodies bodies;
  bodies.positions_m = {ERFA_DAU * (turn * Eigen::Map<const Vector3d>(moon[0])),
                        -ERFA_DAU * (turn * Eigen::Map<const Vector3d>(earth_of_sun[0]))};
  bodies.sidereal_rad = eraGmst06(kJ2000, universal_d, kJ2000, terrestrial_d);
  const double t = terrestrial_d / kDaysPerCentury;
  bodies.delaunay_rad = {eraFal03(t), eraFalp03(t), eraFaf03(t), eraFad03(t), eraFaom03(t)};
  return bodies;
}

TidalBodies TidalBodiesAt(std::string_view utc) {
  const auto time = ParseUtc(utc);
  if (!time) {
    throw InputError(
        "utc",
        "'" + std::string(utc) + "' is no time in UTC from 1972 on, like 2022-10-16T01:50:44Z");
  }
  return TidalBodiesAt(*time);
}

Vector3d SolidEarthTide_m(const TidalBodies& bodies, const Vector3d& position_m) {
  const Station at(position_m);
  Vector3d sum_m = ByFrequencies_m(at, bodies);
  for (std::size_t k = 0; k < kMassRatio.size(); ++k) {
    sum_m += InPhase_m(at, bodies.positions_m[k], kMassRatio[k]) +
             ByBands_m(at, bodies.positions_m[k], kMassRatio[k]);
  }
  return sum_m;
}

Vector3d SolidEarthTide_m(const Geodetic& place, std::string_view utc) {
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Vector3d position_m = frame.FrameFromGeodetic(place);
  return frame.EnuFromFrame(position_m) * SolidEarthTide_m(TidalBodiesAt(utc), position_m);
}

}  // namespace sarblock
