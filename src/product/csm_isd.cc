// SPDX-License-Identifier: Apache-2.0
#include "sarblock/product/csm_isd.h"

#include <cmath>

#include "byte_source.h"
#include "inertial_orbit.h"
#include "io/json_reader.h"
#include "io/number.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr const char* kModel = "USGS_ASTRO_SAR_SENSOR_MODEL";

double Finite(const JsonValue& value) {
  const double number = value.Number();
  if (!std::isfinite(number)) value.Fail("a finite number is needed");
  return number;
}

double Positive(const JsonValue& value) {
  const double number = Finite(value);
  if (!(number > 0.0)) value.Fail(NumberText(number) + " is not allowed, a number above 0 is");
  return number;
}

std::vector<double> Numbers(const JsonValue& list) {
  std::vector<double> numbers;
  for (const JsonValue& entry : list.Entries()) numbers.push_back(Finite(entry));
  return numbers;
}

std::vector<double> Numbers(const JsonValue& list, std::size_t count) {
  std::vector<double> numbers = Numbers(list);
  if (numbers.size() != count) {
    list.Fail(fmt::format("has {} numbers, {} is needed", numbers.size(), count));
  }
  return numbers;
}

Eigen::Vector3d Vector(const JsonValue& list) {
  const std::vector<double> numbers = Numbers(list, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

// The lists `names` of a table, which must be as long as its times.
std::vector<std::vector<JsonValue>> Columns(const JsonValue& table,
                                            const std::vector<const char*>& names) {
  std::vector<std::vector<JsonValue>> columns;
  for (const char* name : names) {
    const JsonValue list = table.Require(name);
    columns.push_back(list.Entries());
    if (columns.back().size() != columns.front().size()) {
      list.Fail(fmt::format("has {} entries beside {} of {}",
                            columns.back().size(),
                            columns.front().size(),
                            names.front()));
    }
  }
  return columns;
}

void RequireInertial(const JsonValue& table) {
  const auto frame = table.Find("reference_frame");
  if (frame && Finite(*frame) != 1.0) frame->Fail("is not allowed, 1 (J2000) is");
}

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
  const auto states = Columns(position, {"ephemeris_times", "positions", "velocities"});
  for (std::size_t i = 0; i < states[0].size(); ++i) {
    orbit.states.push_back({Finite(states[0][i]),
                            kMetresOfKm * Vector(states[1][i]),
                            kMetresOfKm * Vector(states[2][i])});
  }
  const JsonValue rotation = root.Require("body_rotation");
  RequireInertial(rotation);
  const auto attitudes =
      Columns(rotation, {"ephemeris_times", "quaternions", "angular_velocities"});
  for (std::size_t i = 0; i < attitudes[0].size(); ++i) {
    const std::vector<double> q = Numbers(attitudes[1][i], 4);
    orbit.body.push_back(
        {Finite(attitudes[0][i]), {q[0], q[1], q[2], q[3]}, Vector(attitudes[2][i])});
  }
  if (const auto constant = rotation.Find("constant_rotation")) {
    const std::vector<double> rows = Numbers(*constant, 9);
    orbit.constant = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
  }
  return orbit;
}

std::vector<GroundRangePolynomial> IsdGroundRange(const JsonValue& root) {
  std::vector<GroundRangePolynomial> polynomials;
  const auto sets = Columns(root, {"range_conversion_times", "range_conversion_coefficients"});
  for (std::size_t i = 0; i < sets[0].size(); ++i) {
    polynomials.push_back({Finite(sets[0][i]), 0.0, Numbers(sets[1][i], 4)});
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
  const double a_m = unit_m * Positive(radii.Require("semimajor"));
  const double b_m = unit_m * Positive(radii.Require("semiminor"));
  if (b_m > a_m) radii.Fail("a sphere or an oblate ellipsoid of revolution is needed");
  return {"", a_m, 1.0 - b_m / a_m};
}

std::uint64_t AtLeastOne(const JsonValue& value) {
  const std::uint64_t count = value.Count();
  if (count == 0 || count > (1ULL << 53U)) value.Fail("an integer of 1 or more is needed");
  return count;
}

}  // namespace

RadarImage ParseCsmIsd(std::string_view text, const std::string& file) {
  const nlohmann::ordered_json json = ParseJson(text, file);
  const JsonValue root(json, file, "");
  const std::string model = root.Require("name_model").Text();
  if (model != kModel) {
    root.Require("name_model")
        .Fail(Quoted(model) + " is not read, " + kModel + " is: the image of no radar");
  }
  RadarImage image;
  image.file = file;
  image.ellipsoid = IsdEllipsoid(root.Require("radii"));
  image.side = root.Require("look_direction").OneOf({"left", "right"}) == 0 ? LookSide::kLeft
                                                                            : LookSide::kRight;
  image.wavelength_m = Positive(root.Require("wavelength"));
  image.lines = AtLeastOne(root.Require("image_lines"));
  image.samples = AtLeastOne(root.Require("image_samples"));
  image.first_line_s = Finite(root.Require("starting_ephemeris_time"));
  image.line_interval_s = Positive(root.Require("line_exposure_duration"));
  image.sample_spacing_m = Positive(root.Require("scaled_pixel_width"));
  image.ground_range = IsdGroundRange(root);
  image.states = BodyFixedStates(IsdOrbit(root, file), kImageStateStep_s);
  return image;
}

RadarImage ReadCsmIsd(const std::string& file) {
  constexpr std::uint64_t kLargest = 32U << 20U;
  ByteSource source = ByteSource::OfFile(file);
  if (source.size() > kLargest) {
    throw InputError(FilePlace{file, 0, ""}, "is larger than 32 MiB, which no ISD is");
  }
  return ParseCsmIsd(source.Read(0, source.size(), "text"), file);
}

}  // namespace sarblock
