// SPDX-License-Identifier: Apache-2.0
#include "csm.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "bytes.h"
#include "core/text.h"
#include "geometry/smooth_path.h"
#include "isis.h"
#include <fmt/core.h>

namespace sarblock {

double FiniteNumber(const JsonValue& value) {
  const double number = value.Number();
  if (!std::isfinite(number)) value.Fail("a finite number is needed");
  return number;
}

double PositiveNumber(const JsonValue& value) {
  const double number = FiniteNumber(value);
  if (!(number > 0.0)) value.Fail("must be a number above 0, got " + NumberText(number));
  return number;
}

std::vector<double> FiniteNumbers(const JsonValue& list) {
  std::vector<double> numbers;
  for (const JsonValue& entry : list.Entries()) numbers.push_back(FiniteNumber(entry));
  return numbers;
}

std::vector<double> FiniteNumbers(const JsonValue& list, std::size_t count) {
  std::vector<double> numbers = FiniteNumbers(list);
  if (numbers.size() != count) {
    list.Fail(fmt::format("has {} numbers, {} is needed", numbers.size(), count));
  }
  return numbers;
}

Eigen::Vector3d FiniteVector(const JsonValue& list) {
  const std::vector<double> numbers = FiniteNumbers(list, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

std::uint64_t CountOfOne(const JsonValue& value) {
  const std::uint64_t count = value.Count();
  if (count == 0 || count > (1ULL << 53U)) value.Fail("an integer of 1 or more is needed");
  return count;
}

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
  constexpr double kMax = 1e6;
  if (!(span_s > 0.0 && intervals * parts <= kMax)) {
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
            "has {} velocities for {} positions", velocities_mps.size(), positions_m.size()));
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
  ByteSource source = ByteSource::FromFile(file);
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

namespace {

// The lists `names` of a table, which must be as long as its times.
std::vector<std::vector<JsonValue>> ColumnsOf(const JsonValue& table,
                                              const std::vector<const char*>& names) {
  std::vector<std::vector<JsonValue>> columns;
  for (const char* name : names) {
    const JsonValue list = table.Require(name);
    columns.push_back(list.Entries());
    if (columns.back().size() != columns.front().size()) {
      list.Fail(fmt::format("has {} entries but {} of {}",
                            columns.back().size(),
                            columns.front().size(),
                            names.front()));
    }
  }
  return columns;
}

void RequireInertial(const JsonValue& table) {
  const auto frame = table.Find("reference_frame");
  if (frame && FiniteNumber(*frame) != 1.0) frame->Fail("must be 1 (J2000)");
}

std::vector<GroundRangePolynomial> IsdGroundRange(const JsonValue& root) {
  std::vector<GroundRangePolynomial> polynomials;
  const auto sets = ColumnsOf(root, {"range_conversion_times", "range_conversion_coefficients"});
  for (std::size_t i = 0; i < sets[0].size(); ++i) {
    polynomials.push_back({FiniteNumber(sets[0][i]), 0.0, FiniteNumbers(sets[1][i], 4)});
    if (i > 0 && !(polynomials[i].time_s > polynomials[i - 1].time_s)) {
      sets[0][i].Fail("the times must increase");
    }
  }
  if (polynomials.empty()) root.Require("range_conversion_times").Fail("is empty");
  return polynomials;
}

Ellipsoid IsdEllipsoid(const JsonValue& radii) {
  double unit_m = 1e3;
  if (const auto unit = radii.Find("unit")) {
    unit_m = unit->OneOf({"km", "m"}) == 0 ? 1e3 : 1.0;
  }
  const double a_m = unit_m * PositiveNumber(radii.Require("semimajor"));
  const double b_m = unit_m * PositiveNumber(radii.Require("semiminor"));
  if (b_m > a_m) radii.Fail("a sphere or an oblate ellipsoid of revolution is needed");
  return {"", a_m, 1.0 - b_m / a_m};
}

}  // namespace

InertialOrbit IsdOrbit(const JsonValue& root, const std::string& file) {
  constexpr double kMetresOfKm = 1e3;  // of a kilometre
  InertialOrbit orbit;
  orbit.file = file;
  if (!root.Find("instrument_position") && root.Find("sensor_position")) {
    root.Require("sensor_position")
        .Fail("is the form of older ISDs, which is not read: make the ISD again with isd_generate");
  }
  const JsonValue position = root.Require("instrument_position");
  RequireInertial(position);
  const auto states = ColumnsOf(position, {"ephemeris_times", "positions", "velocities"});
  for (std::size_t i = 0; i < states[0].size(); ++i) {
    orbit.states.push_back({FiniteNumber(states[0][i]),
                            kMetresOfKm * FiniteVector(states[1][i]),
                            kMetresOfKm * FiniteVector(states[2][i])});
  }
  const JsonValue rotation = root.Require("body_rotation");
  RequireInertial(rotation);
  const auto attitudes =
      ColumnsOf(rotation, {"ephemeris_times", "quaternions", "angular_velocities"});
  for (std::size_t i = 0; i < attitudes[0].size(); ++i) {
    const std::vector<double> q = FiniteNumbers(attitudes[1][i], 4);
    orbit.body.push_back(
        {FiniteNumber(attitudes[0][i]), {q[0], q[1], q[2], q[3]}, FiniteVector(attitudes[2][i])});
  }
  if (const auto constant = rotation.Find("constant_rotation")) {
    const std::vector<double> rows = FiniteNumbers(*constant, 9);
    orbit.constant = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
  }
  return orbit;
}

void RequireCsmModel(const JsonValue& name) {
  const std::string model = name.Text();
  if (model == kCsmModelName) return;
  name.Fail(Quoted(model) + " is not read, " + kCsmModelName + " is: the image of no radar");
}

RadarImage IsdImage(const JsonValue& root, const std::string& file) {
  RequireCsmModel(root.Require("name_model"));
  RadarImage image;
  image.file = file;
  image.ellipsoid = IsdEllipsoid(root.Require("radii"));
  image.side = root.Require("look_direction").OneOf({"left", "right"}) == 0 ? LookSide::kLeft
                                                                            : LookSide::kRight;
  image.wavelength_m = PositiveNumber(root.Require("wavelength"));
  image.lines = CountOfOne(root.Require("image_lines"));
  image.samples = CountOfOne(root.Require("image_samples"));
  image.first_line_s = FiniteNumber(root.Require("starting_ephemeris_time"));
  image.line_interval_s = PositiveNumber(root.Require("line_exposure_duration"));
  image.sample_spacing_m = PositiveNumber(root.Require("scaled_pixel_width"));
  image.ground_range = IsdGroundRange(root);
  image.states = BodyFixedStates(IsdOrbit(root, file), kImageStateStep_s);
  return image;
}

RadarImage ParseCsmIsd(std::string_view text, const std::string& file) {
  if (IsCsmState(text)) return ParseCsmState(text, file).image;
  const JsonFile json(text, file);
  return IsdImage(json.Root(), file);
}

RadarImage ReadCsmIsd(const std::string& file) { return ParseCsmIsd(ReadCsmText(file), file); }

namespace {

constexpr double kPartsOfInterval = 32.0;

// Nodes before and after the interval's first one: eight in the middle, fewer towards the ends.
std::ptrdiff_t NodesEachSide(std::ptrdiff_t interval, std::ptrdiff_t count) {
  if (interval >= 3 && interval < count - 4) return 4;
  if (interval >= 2 && interval < count - 3) return 3;
  if (interval >= 1 && interval < count - 2) return 2;
  return 1;
}

// At its own time, linear between two, that of the end beyond.
std::vector<double> PolynomialsAtTime(const std::vector<GroundRangePolynomial>& given,
                                      double time_s) {
  const auto above = std::upper_bound(
      given.begin(), given.end(), time_s, [](double t, const GroundRangePolynomial& polynomial) {
        return t < polynomial.time_s;
      });
  if (above == given.begin()) return above->coefficients;
  if (above == given.end()) return given.back().coefficients;
  const GroundRangePolynomial& a = *(above - 1);
  const GroundRangePolynomial& b = *above;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  std::vector<double> coefficients = a.coefficients;
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    coefficients[k] += part * (b.coefficients[k] - a.coefficients[k]);
  }
  return coefficients;
}

}  // namespace

std::vector<double> AsUsgscsmInterpolates(const std::vector<std::vector<double>>& rows,
                                          double place) {
  const auto count = static_cast<std::ptrdiff_t>(rows.size());
  const auto interval =
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(place)), 0, count - 2);
  const std::ptrdiff_t half = NodesEachSide(interval, count);
  std::vector<double> sum(rows.front().size(), 0.0);
  for (std::ptrdiff_t i = interval - half + 1; i <= interval + half; ++i) {
    double weight = 1.0;
    for (std::ptrdiff_t j = interval - half + 1; j <= interval + half; ++j) {
      if (j == i) continue;
      weight *= (place - static_cast<double>(j)) / static_cast<double>(i - j);
    }
    const std::vector<double>& row = rows[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * row[k];
  }
  return sum;
}

std::vector<GroundRangePolynomial> ForUsgscsm(const std::vector<GroundRangePolynomial>& given,
                                              double start_s,
                                              double end_s) {
  if (given.size() < 2) return given;
  constexpr std::size_t kIntervals = 2048, kBeyond = 4;
  const double step_s = (end_s - start_s) / static_cast<double>(kIntervals);
  const double first_s = start_s - static_cast<double>(kBeyond) * step_s;
  std::vector<GroundRangePolynomial> written;
  constexpr std::size_t kCount = kIntervals + 1 + 2 * kBeyond;
  for (std::size_t k = 0; k < kCount; ++k) {
    const double time_s = first_s + static_cast<double>(k) * step_s;
    written.push_back({time_s, given.front().origin_m, PolynomialsAtTime(given, time_s)});
  }
  // USGSCSM divides the span by the number of polynomials, not by that of the intervals.
  written.back().time_s += step_s;
  return written;
}

std::vector<GroundRangePolynomial> AsUsgscsmReads(const std::vector<GroundRangePolynomial>& given,
                                                  double start_s,
                                                  double end_s) {
  if (given.size() < 2) return given;
  const double first_s = given.front().time_s;
  const double step_s = (given.back().time_s - first_s) / static_cast<double>(given.size());
  const double part_s = step_s / kPartsOfInterval;
  // Through the nodes, where one interpolating polynomial ends and the next begins.
  const double from = std::floor((std::min(start_s, first_s) - first_s) / part_s);
  const double to = std::ceil((std::max(end_s, given.back().time_s) - first_s) / part_s);
  constexpr double kMax = 1e5;
  if (to - from > kMax) {
    throw InputError("ground_range", "polynomials are too close in time for the path");
  }
  std::vector<std::vector<double>> rows;
  for (const GroundRangePolynomial& polynomial : given) rows.push_back(polynomial.coefficients);
  std::vector<GroundRangePolynomial> close;
  for (double part = from; part <= to; part += 1.0) {
    close.push_back({first_s + part * part_s,
                     given.front().origin_m,
                     AsUsgscsmInterpolates(rows, part / kPartsOfInterval)});
  }
  return close;
}

}  // namespace sarblock
