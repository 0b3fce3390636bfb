// SPDX-License-Identifier: Apache-2.0
#include "reduction.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/reduction/reduction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "core/utc.h"
#include "frames.h"
#include <Eigen/Geometry>
#include <erfa.h>
#include <erfam.h>

namespace sarblock {

// ---- the atmosphere

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

// ---- the solid Earth tide

using Eigen::Vector3d;

namespace {

constexpr double kEarthRadius_m = 6378136.6;
// Masses of Moon and Sun over that of the Earth: IERS Conventions (2010), table 1.1.
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

// ---- the looks of a block

namespace {

constexpr std::size_t kLooksPerPiece = 16384;
constexpr double kSecondsPerYear = 365.25 * 86400.0;

std::size_t IndexOf(ReductionSource source) { return static_cast<std::size_t>(source); }

const char* NameOf(ReductionSource source) {
  constexpr std::array<const char*, kReductionSources> kNames{
      "given", "troposphere", "ionosphere", "tide", "motion", "constant"};
  return kNames[IndexOf(source)];
}

double HeightOf(const Frame& frame, const Eigen::Vector3d& p_m) {
  return frame.kind() == FrameKind::kLocal ? p_m.z() : frame.GeodeticFromFrame(p_m).h_m;
}

/// Key and problem.
using KeyProblem = std::pair<std::string, std::string>;

std::optional<KeyProblem> OutOfBounds(const ReductionModels& models) {
  constexpr double kLargest_m = 10e3, kLargest_s = 1.0;
  const auto constant = [](const char* key, double value, double largest) {
    return std::abs(value) <= largest
               ? std::optional<KeyProblem>()
               : KeyProblem{key,
                            "must be between -" + NumberText(largest) + " and " +
                                NumberText(largest) + ", got " + NumberText(value)};
  };
  if (auto problem = constant("reduction.range_m", models.range_m, kLargest_m)) return problem;
  if (auto problem = constant("reduction.time_s", models.time_s, kLargest_s)) return problem;
  const char* model = "";
  try {
    if (models.troposphere == TroposphereModel::kWeather) {
      model = "reduction.troposphere.";
      Validate(models.weather);
    }
    if (models.ionosphere) {
      model = "reduction.ionosphere.";
      Validate(*models.ionosphere);
    }
  } catch (const InputError& error) {
    return KeyProblem{model + error.place().field, error.problem()};
  }
  return std::nullopt;
}

/// Whether points move between the epoch of their positions and the dates of the images.
bool Moves(const Block& block) {
  return !std::isnan(block.epoch_year) &&
         std::any_of(block.points.known.begin(),
                     block.points.known.end(),
                     [](const KnownPosition& known) { return !known.velocity_mpy.isZero(0.0); });
}

std::optional<KeyProblem> Unusable(const Block& block,
                                   const Pass& pass,
                                   const ReductionModels& models) {
  if (auto out = OutOfBounds(models)) return out;
  const Frame& frame = block.frame;
  const bool other = frame.kind() == FrameKind::kGeocentric && !IsEarth(frame);
  const std::string body = "is a model of the Earth, the frame is that of another body (" +
                           frame.ellipsoid().name + "); \"none\" is allowed";
  if (models.troposphere != TroposphereModel::kNone && other)
    return KeyProblem{"reduction.troposphere", body};
  if (models.ionosphere) {
    constexpr double kIonosphere_m = 60e3;
    if (other) {
      return KeyProblem{"reduction.ionosphere",
                        "is that of the Earth, the frame is that of another body (" +
                            frame.ellipsoid().name + "); leave it out"};
    }
    if (std::isnan(pass.wavelength_m)) {
      return KeyProblem{"reduction.ionosphere", "needs wavelength_m of pass " + Quoted(pass.id)};
    }
    if (HeightOf(frame, pass.path.states().front().position_m) < kIonosphere_m) {
      return KeyProblem{"reduction.ionosphere",
                        "lies above the antenna of pass " + Quoted(pass.id) +
                            ", which is lower than 60 km; leave it out"};
    }
  }
  if (models.solid_tide) {
    if (other) return KeyProblem{"reduction.tide", body};
    if (frame.kind() == FrameKind::kLocal) {
      return KeyProblem{"reduction.tide",
                        "needs a geocentric frame: the place on the Earth is not known"};
    }
  }
  if ((models.solid_tide || Moves(block)) && !ParseUtc(pass.epoch_utc)) {
    return KeyProblem{
        "epoch_utc",
        std::string(models.solid_tide ? "tides need" : "the motion of known points needs") +
            " the date of pass " + Quoted(pass.id) + "; " + Quoted(pass.epoch_utc) +
            " is no UTC time, 2022-10-16T01:50:44Z is one"};
  }
  if (models.solid_tide) {
    try {
      static_cast<void>(TidalBodiesAt(ParseUtc(pass.epoch_utc).value()));
    } catch (const InputError& error) {
      return KeyProblem{"epoch_utc", "tides need the date: " + error.problem()};
    }
  }
  return std::nullopt;
}

}  // namespace

double SlantFactor(double cos_zenith) {
  return 1.001 / std::sqrt(0.002001 + cos_zenith * cos_zenith);
}

double LookReduction::Range_m() const {
  return std::accumulate(range_m.begin(), range_m.end(), 0.0);
}

double LookReduction::Time_s() const { return std::accumulate(time_s.begin(), time_s.end(), 0.0); }

std::optional<ReductionProblem> FindProblem(const Block& block,
                                            const std::vector<ReductionModels>& models) {
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    if (auto problem = Unusable(block, block.passes[pass], models[pass])) {
      return ReductionProblem{pass, std::move(problem->first), std::move(problem->second)};
    }
  }
  return std::nullopt;
}

std::vector<ReductionModels> ModelsOf(const Block& block) {
  std::vector<ReductionModels> models;
  models.reserve(block.passes.size());
  for (const Pass& pass : block.passes) models.push_back(pass.reduction);
  return models;
}

struct ReductionOfLooks::PassModel {
  ReductionModels models;
  /// Sun and Moon at even times: the tide changes by 0.01 mm a second.
  std::vector<TidalBodies> bodies;
  double bodies_start_s = 0.0;
  double since_epoch_year = kNotGiven;  ///< time 0 of the pass after the epoch of the positions
};

namespace {

constexpr double kBetweenBodies_s = 20.0;

bool IsAnything(const ReductionModels& models) { return models != ReductionModels{}; }

}  // namespace

ReductionOfLooks::ReductionOfLooks(const Block& block, std::vector<ReductionModels> models)
    : block_(block) {
  if (const auto problem = FindProblem(block, models)) {
    throw InputError("passes[" + std::to_string(problem->pass) + "]." + problem->key,
                     problem->problem);
  }
  any_ = Moves(block) || std::any_of(models.begin(), models.end(), IsAnything);
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Pass& pass = block.passes[i];
    PassModel& own = passes_.emplace_back();
    own.models = models[i];
    const std::optional<UtcTime> epoch = ParseUtc(pass.epoch_utc);
    if (epoch) own.since_epoch_year = JulianYear(*epoch) - block.epoch_year;
    if (!own.models.solid_tide) continue;
    own.bodies_start_s = pass.path.start_s();
    const auto count =
        1 + static_cast<std::size_t>((pass.path.end_s() - own.bodies_start_s) / kBetweenBodies_s);
    for (std::size_t k = 0; k < count; ++k) {
      const double time_s = own.bodies_start_s + (static_cast<double>(k) + 0.5) * kBetweenBodies_s;
      own.bodies.push_back(TidalBodiesAt(AddSeconds(*epoch, time_s)));
    }
  }
}

ReductionOfLooks::~ReductionOfLooks() = default;
ReductionOfLooks::ReductionOfLooks(ReductionOfLooks&&) noexcept = default;

bool ReductionOfLooks::any() const { return any_; }

LookReduction ReductionOfLooks::Of(std::uint32_t pass,
                                   double time_s,
                                   const Cone& cone,
                                   const Eigen::Vector3d& p_m,
                                   const Eigen::Vector3d& velocity_mpy) const {
  LookReduction out;
  const PassModel& own = passes_[pass];
  const ReductionModels& models = own.models;
  out.range_m[IndexOf(ReductionSource::kConstant)] = models.range_m;
  out.time_s[IndexOf(ReductionSource::kConstant)] = models.time_s;
  const std::optional<Motion> antenna =
      p_m.allFinite() ? block_.passes[pass].path.At(time_s) : std::nullopt;
  if (!antenna) return out;
  const Frame& frame = block_.frame;
  const Eigen::Vector3d sight_m = antenna->position_m - p_m;
  if (models.troposphere != TroposphereModel::kNone || models.ionosphere) {
    const Eigen::Vector3d up = frame.UpAt(p_m);
    const double cos_zenith = up.dot(sight_m) / sight_m.norm();
    const double latitude_rad =
        frame.kind() == FrameKind::kLocal ? std::numbers::pi / 4.0 : std::asin(up.z());
    constexpr double kSpace_m = 200e3;  // nothing is above it: 1e-12 m
    const bool in_space = up.dot(sight_m) > kSpace_m;
    const auto zenith_m = [&](double height_m) {
      return models.troposphere == TroposphereModel::kStandard
                 ? ZenithDelay_m(height_m)
                 : ZenithDelay_m(models.weather, latitude_rad, height_m);
    };
    if (models.troposphere != TroposphereModel::kNone) {
      out.range_m[IndexOf(ReductionSource::kTroposphere)] =
          (zenith_m(HeightOf(frame, p_m)) -
           (in_space ? 0.0 : zenith_m(HeightOf(frame, antenna->position_m)))) *
          SlantFactor(cos_zenith);
    }
    if (models.ionosphere) {
      out.range_m[IndexOf(ReductionSource::kIonosphere)] =
          IonosphericDelay_m(*models.ionosphere,
                             block_.passes[pass].wavelength_m,
                             std::acos(std::clamp(cos_zenith, 0.0, 1.0)));
    }
  }
  const bool moves = !velocity_mpy.isZero(0.0) && !std::isnan(own.since_epoch_year);
  if (!models.solid_tide && !moves) return out;
  LookGeometry look{.line_of_sight_m = -sight_m, .motion = *antenna, .cone = cone};
  LookPrediction seen;
  if (!PredictLook(look, &seen)) return out;
  const auto displace = [&](ReductionSource source, const Eigen::Vector3d& by_m) {
    out.range_m[IndexOf(source)] = seen.d_point.row(0).dot(by_m);
    out.time_s[IndexOf(source)] = seen.d_point.row(1).dot(by_m);
  };
  if (models.solid_tide) {
    const auto k =
        static_cast<std::size_t>(std::max(0.0, (time_s - own.bodies_start_s) / kBetweenBodies_s));
    const TidalBodies& bodies = own.bodies[std::min(k, own.bodies.size() - 1)];
    displace(ReductionSource::kTide, SolidEarthTide_m(bodies, p_m));
  }
  if (moves) {
    const double years = own.since_epoch_year + time_s / kSecondsPerYear;
    displace(ReductionSource::kMotion, years * velocity_mpy);
  }
  return out;
}

namespace {

/// Calls work(piece, look, point) for all looks, pieces side by side.
template <typename Work>
void ForLooks(const Looks& looks, const Work& work) {
  ParallelForChunks(
      looks.size(), kLooksPerPiece, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        std::size_t point = looks.PointOf(begin);
        for (std::size_t look = begin; look < end; ++look) {
          while (looks.offsets[point + 1] <= look) ++point;
          work(piece, look, point);
        }
      });
}

std::size_t PiecesOf(const Looks& looks) {
  return (looks.size() + kLooksPerPiece - 1) / kLooksPerPiece;
}

}  // namespace

ReducedBlock::ReducedBlock(const Block& block) : given_(block), models_(block, ModelsOf(block)) {
  position_m_.assign(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  if (!models_.any()) return;
  reduced_ = block;
  for (Pass& pass : reduced_->passes) pass.reduction = {};
  for (KnownPosition& known : reduced_->points.known) known.velocity_mpy.setZero();
  Looks& now = reduced_->looks;
  now.range_delay_m.resize(now.size());
  now.time_shift_s.resize(now.size());
  ForLooks(now, [&](std::size_t, std::size_t look, std::size_t point) {
    const LookReduction constants = Of(look, point, position_m_[point]);
    now.range_delay_m[look] = constants.Range_m();
    now.time_shift_s[look] = constants.Time_s();
  });
  TakeOff();
}

LookReduction ReducedBlock::Of(std::size_t look,
                               std::size_t point,
                               const Eigen::Vector3d& p_m) const {
  const Looks& looks = given_.looks;
  const KnownPosition* known = given_.points.FindKnown(static_cast<std::uint32_t>(point));
  const Eigen::Vector3d velocity_mpy =
      known == nullptr ? Eigen::Vector3d::Zero() : known->velocity_mpy;
  LookReduction out =
      models_.Of(looks.pass[look], looks.time_s[look], given_.ConeOf(look), p_m, velocity_mpy);
  constexpr std::size_t kGiven = 0;
  if (!looks.range_delay_m.empty()) out.range_m[kGiven] = looks.range_delay_m[look];
  if (!looks.time_shift_s.empty()) out.time_s[kGiven] = looks.time_shift_s[look];
  return out;
}

double ReducedBlock::ReduceAt(const std::vector<Eigen::Vector3d>& position_m, double settled_m) {
  if (!reduced_) return 0.0;
  Looks& now = reduced_->looks;
  std::vector<double> range_delay_m = now.range_delay_m, time_shift_s = now.time_shift_s;
  std::vector<double> changes_m(PiecesOf(now), 0.0);
  ForLooks(now, [&](std::size_t piece, std::size_t look, std::size_t point) {
    if (!position_m[point].allFinite()) return;
    const LookReduction at = Of(look, point, position_m[point]);
    range_delay_m[look] = at.Range_m();
    time_shift_s[look] = at.Time_s();
    if (now.rejected(look)) return;
    const double speed_mps =
        given_.passes[now.pass[look]].path.states().front().velocity_mps.norm();
    changes_m[piece] =
        std::max({changes_m[piece],
                  std::abs(range_delay_m[look] - now.range_delay_m[look]),
                  speed_mps * std::abs(time_shift_s[look] - now.time_shift_s[look])});
  });
  const double largest_m =
      changes_m.empty() ? 0.0 : *std::max_element(changes_m.begin(), changes_m.end());
  if (!(largest_m > settled_m)) return largest_m;
  now.range_delay_m = std::move(range_delay_m);
  now.time_shift_s = std::move(time_shift_s);
  TakeOff();
  for (std::size_t point = 0; point < position_m.size(); ++point) {
    if (position_m[point].allFinite()) position_m_[point] = position_m[point];
  }
  return largest_m;
}

void ReducedBlock::TakeOff() {
  Looks& now = reduced_->looks;
  ForLooks(now, [&](std::size_t, std::size_t look, std::size_t) {
    const RadarCoordinates measured = given_.Measured(look);
    now.range_m[look] = measured.range_m - now.range_delay_m[look];
    now.time_s[look] = measured.time_s - now.time_shift_s[look];
  });
}

namespace {

/// Statistics of one quantity over the looks of one pass.
struct Spread {
  double sum = 0.0, count = 0.0;
  double least = std::numeric_limits<double>::infinity();
  double largest = -std::numeric_limits<double>::infinity();

  void Add(double value) {
    sum += value;
    count += 1.0;
    least = std::min(least, value);
    largest = std::max(largest, value);
  }
  void Add(const Spread& other) {
    sum += other.sum;
    count += other.count;
    least = std::min(least, other.least);
    largest = std::max(largest, other.largest);
  }
  [[nodiscard]] bool IsNothing() const { return count == 0.0 || (least == 0.0 && largest == 0.0); }
};

}  // namespace

Reductions ReducedBlock::Report() const {
  const Looks& looks = block().looks;
  Reductions out;
  const auto used = [](const std::vector<double>& column) {
    return std::any_of(column.begin(), column.end(), [](double value) { return value != 0.0; });
  };
  if (used(looks.range_delay_m)) out.range_m = looks.range_delay_m;
  if (used(looks.time_shift_s)) out.time_s = looks.time_shift_s;
  if (out.range_m.empty() && out.time_s.empty()) return out;
  using OfPass = std::array<std::array<Spread, kReductionSources>, 2>;
  // Few pieces: each has the sums of all passes.
  constexpr std::size_t kMostPieces = 32;
  const std::size_t points = given_.points.size();
  const std::size_t points_per_piece = points / kMostPieces + 1;
  std::vector<std::vector<OfPass>> pieces(points / points_per_piece + 1,
                                          std::vector<OfPass>(given_.passes.size()));
  ParallelForChunks(
      points, points_per_piece, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        for (std::size_t i = looks.offsets[begin], point = begin; i < looks.offsets[end]; ++i) {
          while (looks.offsets[point + 1] <= i) ++point;
          if (looks.rejected(i) || std::isnan(looks.range_m[i])) continue;
          const LookReduction at = Of(i, point, position_m_[point]);
          OfPass& own = pieces[piece][looks.pass[i]];
          for (std::size_t k = 0; k < kReductionSources; ++k) {
            own[0][k].Add(at.range_m[k]);
            own[1][k].Add(at.time_s[k]);
          }
        }
      });
  std::vector<OfPass> passes(given_.passes.size());
  for (const std::vector<OfPass>& piece : pieces) {
    for (std::size_t pass = 0; pass < passes.size(); ++pass) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        for (std::size_t k = 0; k < kReductionSources; ++k) {
          passes[pass][axis][k].Add(piece[pass][axis][k]);
        }
      }
    }
  }
  for (std::size_t pass = 0; pass < passes.size(); ++pass) {
    for (std::size_t k = 0; k < kReductionSources; ++k) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const Spread& spread = passes[pass][axis][k];
        if (spread.IsNothing()) continue;
        out.terms.push_back({static_cast<std::uint32_t>(pass),
                             NameOf(static_cast<ReductionSource>(k)),
                             axis == 0 ? "m" : "s",
                             spread.sum / spread.count,
                             spread.least,
                             spread.largest});
      }
    }
  }
  return out;
}

}  // namespace sarblock
