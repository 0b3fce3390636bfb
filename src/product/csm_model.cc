// SPDX-License-Identifier: Apache-2.0
#include "csm_model.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "byte_source.h"
#include "csm_isd_parts.h"
#include "geometry/smooth_path.h"
#include "inertial_orbit.h"
#include "json_numbers.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kParameters = 6;

std::string TextOr(const JsonValue& root, const char* name, const char* otherwise) {
  const auto value = root.Find(name);
  return value ? value->Text() : otherwise;
}

CsmStateTimes TimesOfIsd(const JsonValue& root) {
  const JsonValue list = root.Require("instrument_position").Require("ephemeris_times");
  const std::vector<double> given_s = FiniteNumbers(list);
  if (given_s.size() < 2) list.Fail("has less than two times");
  const double span_s = given_s.back() - given_s.front();
  const auto intervals = static_cast<double>(given_s.size() - 1);
  const double parts = std::max(1.0, std::ceil(span_s / (intervals * CsmModel::kLongestStep_s)));
  constexpr auto kBeyond = static_cast<double>(CsmModel::kBeyond);
  constexpr double kMost = 1e6;
  if (!(span_s > 0.0 && intervals * parts <= kMost)) {
    list.Fail(fmt::format("go over {} s, which no image takes", span_s));
  }
  CsmStateTimes times;
  times.step_s = span_s / (intervals * parts);
  times.first_s = given_s.front() - kBeyond * times.step_s;
  times.count = static_cast<std::size_t>(intervals * parts + 1.0 + 2.0 * kBeyond);
  return times;
}

// The Sun turns with the body: places on a straight line, at the times at which USGSCSM takes the
// list of them, (lines times duration) / count apart from the first state.
void SetSun(const JsonValue& root, const std::string& file, CsmModel* model) {
  const auto sun = root.Find("sun_position");
  if (!sun || !sun->Find("positions") || !sun->Find("velocities")) return;
  constexpr double kMetresOfKm = 1e3;
  constexpr std::size_t kPlaces = 16;
  const std::vector<JsonValue> times = sun->Require("ephemeris_times").Entries();
  const std::vector<JsonValue> positions = sun->Require("positions").Entries();
  const std::vector<JsonValue> velocities = sun->Require("velocities").Entries();
  if (times.empty() || positions.size() != times.size() || velocities.size() != times.size()) {
    sun->Fail("has lists of different lengths, or empty ones");
  }
  const double time_s = FiniteNumber(times.front());
  const Eigen::Vector3d position_m = kMetresOfKm * FiniteVector(positions.front());
  const Eigen::Vector3d velocity_mps = kMetresOfKm * FiniteVector(velocities.front());
  InertialOrbit orbit = IsdOrbit(root, file);
  orbit.states.clear();
  const double span_s = static_cast<double>(model->image.lines) * model->image.line_interval_s;
  for (std::size_t k = 0; k < kPlaces; ++k) {
    const double at_s = model->times.first_s + span_s * static_cast<double>(k) / kPlaces;
    orbit.states.push_back({at_s, position_m + velocity_mps * (at_s - time_s), velocity_mps});
  }
  std::vector<StateVector> states;
  try {
    states = BodyFixedStates(orbit, span_s);
  } catch (const InputError& error) {
    sun->Fail(error.what());
  }
  for (const StateVector& state : states) {
    for (const double value : state.position_m) model->sun_position_m.push_back(value);
    for (const double value : state.velocity_mps) model->sun_velocity_mps.push_back(value);
  }
}

CsmModel ParseIsdModel(std::string_view text, const std::string& file) {
  const JsonFile json(text, file);
  const JsonValue root = json.Root();
  CsmModel model;
  model.image = IsdImage(root, file);
  const RadarImage& image = model.image;
  model.times = TimesOfIsd(root);
  model.end_s = image.first_line_s + static_cast<double>(image.lines) * image.line_interval_s;
  if (const auto end = root.Find("ending_ephemeris_time")) model.end_s = FiniteNumber(*end);
  model.centre_s = 0.5 * (image.first_line_s + model.end_s);
  if (const auto centre = root.Find("center_ephemeris_time")) {
    model.centre_s = FiniteNumber(*centre);
  }
  model.image_id = TextOr(root, "image_identifier", "Unknown");
  model.sensor = TextOr(root, "name_sensor", "Unknown");
  model.platform = TextOr(root, "name_platform", "Unknown");
  constexpr double kUsualHeight_m = 1000.0;  // of ISDs and of USGSCSM where they give none
  model.least_height_m = -kUsualHeight_m;
  model.most_height_m = kUsualHeight_m;
  if (const auto heights = root.Find("reference_height")) {
    const auto unit = heights->Find("unit");
    const double unit_m = unit && unit->OneOf({"m", "km"}) == 1 ? 1e3 : 1.0;
    model.least_height_m = unit_m * FiniteNumber(heights->Require("minheight"));
    model.most_height_m = unit_m * FiniteNumber(heights->Require("maxheight"));
  }
  SetSun(root, file, &model);
  return model;
}

// Triples of a flat list.
std::vector<Eigen::Vector3d> Triples(const JsonValue& list) {
  const std::vector<double> numbers = FiniteNumbers(list);
  if (numbers.size() % 3 != 0) list.Fail("is no list of three coordinates each");
  std::vector<Eigen::Vector3d> triples;
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    triples.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  }
  return triples;
}

std::vector<StateVector> StatesOfModel(const JsonValue& root, CsmStateTimes* times) {
  times->first_s = FiniteNumber(root.Require("m_t0Ephem"));
  times->step_s = PositiveNumber(root.Require("m_dtEphem"));
  const std::vector<double> parameters =
      FiniteNumbers(root.Require("m_currentParameterValue"), kParameters);
  const Eigen::Vector3d offset_m(parameters[0], parameters[1], parameters[2]);
  if (parameters[3] != 0.0 || parameters[4] != 0.0 || parameters[5] != 0.0) {
    root.Require("m_currentParameterValue")
        .Fail(
            "has parameters of the velocity, which turn the Doppler cone without moving the "
            "path: they are not read, zeros are");
  }
  const std::vector<Eigen::Vector3d> positions_m = Triples(root.Require("m_positions"));
  const std::vector<Eigen::Vector3d> velocities_mps = Triples(root.Require("m_velocities"));
  if (positions_m.size() < 2) root.Require("m_positions").Fail("has less than two positions");
  if (velocities_mps.size() != positions_m.size()) {
    root.Require("m_velocities")
        .Fail(fmt::format(
            "has {} velocities beside {} positions", velocities_mps.size(), positions_m.size()));
  }
  times->count = positions_m.size();
  std::vector<StateVector> states;
  for (std::size_t k = 0; k < positions_m.size(); ++k) {
    states.push_back({times->At(k), positions_m[k] + offset_m, velocities_mps[k]});
  }
  // 1 mm/s of the 1600 m/s of an orbit around the Moon turns the Doppler plane by 6 cm at 100 km.
  constexpr double kContradiction_mps = 1e-3;
  const double contradiction_mps = Contradiction_mps(states, EstimateStateNoise(states));
  if (contradiction_mps > kContradiction_mps) {
    root.Require("m_velocities")
        .Fail(fmt::format(
            "differ from the motion of m_positions by {:.3g} m/s across it: "
            "velocities that turn the Doppler cone without moving the path are not read",
            contradiction_mps));
  }
  return states;
}

std::vector<GroundRangePolynomial> PolynomialsOfModel(const JsonValue& root) {
  constexpr std::size_t kCoefficients = 4;
  const JsonValue list = root.Require("m_scaleConversionTimes");
  const std::vector<double> times_s = FiniteNumbers(list);
  if (times_s.empty()) list.Fail("is empty");
  const std::vector<double> numbers =
      FiniteNumbers(root.Require("m_scaleConversionCoefficients"), kCoefficients * times_s.size());
  std::vector<GroundRangePolynomial> polynomials;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    if (i > 0 && !(times_s[i] > times_s[i - 1])) list.Fail("the times must increase");
    const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(kCoefficients * i);
    polynomials.push_back({times_s[i], 0.0, {first, first + kCoefficients}});
  }
  return polynomials;
}

nlohmann::ordered_json FlatList(const std::vector<StateVector>& states,
                                Eigen::Vector3d StateVector::*member) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const StateVector& state : states) {
    for (const double value : state.*member) list.push_back(value);
  }
  return list;
}

// One key a line.
std::string LinesOf(const nlohmann::ordered_json& object) {
  std::string text = "{";
  for (const auto& [key, value] : object.items()) {
    text += text.size() > 1 ? ",\n" : "\n";
    text += nlohmann::ordered_json(key).dump() + ": " + value.dump();
  }
  return text + "\n}\n";
}

}  // namespace

bool IsCsmState(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return false;
  if (text.substr(first).starts_with(kCsmModelName)) return true;
  // Without the line of the name, as some programs keep it.
  return text.find("\"m_modelName\"") != std::string_view::npos;
}

CsmModel ParseCsmState(std::string_view text, const std::string& file) {
  std::string json_text(text);
  const std::size_t first = json_text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && json_text.compare(first, 1, "{") != 0) {
    // Blanks in its place keep the numbers of the lines.
    const std::size_t end = std::min(json_text.find('\n', first), json_text.size());
    std::fill_n(json_text.begin(), end, ' ');
  }
  const JsonFile json(json_text, file);
  const JsonValue root = json.Root();
  RequireCsmModel(root.Require("m_modelName"));
  CsmModel model;
  RadarImage& image = model.image;
  image.file = file;
  const double a_m = PositiveNumber(root.Require("m_majorAxis"));
  const double b_m = PositiveNumber(root.Require("m_minorAxis"));
  if (b_m > a_m) root.Require("m_minorAxis").Fail("is above m_majorAxis");
  image.ellipsoid = {"", a_m, 1.0 - b_m / a_m};
  image.side = root.Require("m_lookDirection").OneOf({"left", "right"}) == 0 ? LookSide::kLeft
                                                                             : LookSide::kRight;
  image.wavelength_m = PositiveNumber(root.Require("m_wavelength"));
  image.lines = CountOfOne(root.Require("m_nLines"));
  image.samples = CountOfOne(root.Require("m_nSamples"));
  image.first_line_s = FiniteNumber(root.Require("m_startingEphemerisTime"));
  image.line_interval_s = PositiveNumber(root.Require("m_exposureDuration"));
  image.sample_spacing_m = PositiveNumber(root.Require("m_scaledPixelWidth"));
  image.ground_range = PolynomialsOfModel(root);
  image.states = StatesOfModel(root, &model.times);
  model.centre_s = FiniteNumber(root.Require("m_centerEphemerisTime"));
  model.end_s = FiniteNumber(root.Require("m_endingEphemerisTime"));
  model.least_height_m = FiniteNumber(root.Require("m_minElevation"));
  model.most_height_m = FiniteNumber(root.Require("m_maxElevation"));
  model.image_id = TextOr(root, "m_imageIdentifier", "Unknown");
  model.sensor = TextOr(root, "m_sensorName", "Unknown");
  model.platform = TextOr(root, "m_platformName", "Unknown");
  if (const auto sun = root.Find("m_sunPosition")) model.sun_position_m = FiniteNumbers(*sun);
  if (const auto sun = root.Find("m_sunVelocity")) model.sun_velocity_mps = FiniteNumbers(*sun);
  return model;
}

CsmModel ParseCsmModel(std::string_view text, const std::string& file) {
  return IsCsmState(text) ? ParseCsmState(text, file) : ParseIsdModel(text, file);
}

std::string ReadCsmText(const std::string& file) {
  constexpr std::uint64_t kLargest = 256U << 20U;
  ByteSource source = ByteSource::OfFile(file);
  if (source.size() > kLargest) {
    throw InputError(FilePlace{file, 0, ""},
                     "is larger than 256 MiB, which no ISD and no model state is");
  }
  return source.Read(0, source.size(), "text");
}

CsmModel ReadCsmModel(const std::string& file) { return ParseCsmModel(ReadCsmText(file), file); }

std::string CsmStateText(const CsmModel& model, const AdjustedCsmModel& adjusted) {
  const RadarImage& image = model.image;
  const double shift_s = adjusted.time_shift_s;
  std::vector<double> coefficients, times_s, covariance;
  for (const GroundRangePolynomial& polynomial : adjusted.ground_range) {
    times_s.push_back(polynomial.time_s + shift_s);
    coefficients.insert(
        coefficients.end(), polynomial.coefficients.begin(), polynomial.coefficients.end());
  }
  for (Eigen::Index i = 0; i < adjusted.covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < adjusted.covariance.cols(); ++j) {
      covariance.push_back(adjusted.covariance(i, j));
    }
  }
  const Eigen::Vector3d& reference_m = adjusted.reference_m;
  const nlohmann::ordered_json json = {
      {"m_modelName", kCsmModelName},
      {"written_by", std::string("written by sarblock ") + Version()},
      {"m_imageIdentifier", model.image_id},
      {"m_sensorName", model.sensor},
      {"m_platformName", model.platform},
      {"m_platformIdentifier", model.platform},
      {"m_sensorIdentifier", model.sensor},
      {"m_nLines", image.lines},
      {"m_nSamples", image.samples},
      {"m_referencePointXyz", {reference_m.x(), reference_m.y(), reference_m.z()}},
      {"m_startingEphemerisTime", image.first_line_s + shift_s},
      {"m_centerEphemerisTime", model.centre_s + shift_s},
      {"m_endingEphemerisTime", model.end_s + shift_s},
      {"m_exposureDuration", image.line_interval_s},
      {"m_majorAxis", image.ellipsoid.a_m},
      {"m_minorAxis", image.ellipsoid.a_m * (1.0 - image.ellipsoid.flattening)},
      {"m_minElevation", model.least_height_m},
      {"m_maxElevation", model.most_height_m},
      {"m_lookDirection", image.side == LookSide::kLeft ? "left" : "right"},
      {"m_wavelength", image.wavelength_m},
      {"m_scaledPixelWidth", image.sample_spacing_m},
      {"m_currentParameterValue", std::vector<double>(kParameters, 0.0)},
      {"m_covariance", covariance},
      {"m_t0Ephem", model.times.first_s},
      {"m_dtEphem", model.times.step_s},
      {"m_sunPosition", model.sun_position_m},
      {"m_sunVelocity", model.sun_velocity_mps},
      {"m_scaleConversionTimes", times_s},
      {"m_scaleConversionCoefficients", coefficients},
      {"m_positions", FlatList(adjusted.states, &StateVector::position_m)},
      {"m_velocities", FlatList(adjusted.states, &StateVector::velocity_mps)}};
  return std::string(kCsmModelName) + "\n" + LinesOf(json);
}

}  // namespace sarblock
