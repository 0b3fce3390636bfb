// SPDX-License-Identifier: Apache-2.0
#include "csm_isd_parts.h"

#include "core/text.h"
#include "json_numbers.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

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
  if (frame && FiniteNumber(*frame) != 1.0) frame->Fail("is not allowed, 1 (J2000) is");
}

std::vector<GroundRangePolynomial> IsdGroundRange(const JsonValue& root) {
  std::vector<GroundRangePolynomial> polynomials;
  const auto sets = Columns(root, {"range_conversion_times", "range_conversion_coefficients"});
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
  const auto states = Columns(position, {"ephemeris_times", "positions", "velocities"});
  for (std::size_t i = 0; i < states[0].size(); ++i) {
    orbit.states.push_back({FiniteNumber(states[0][i]),
                            kMetresOfKm * FiniteVector(states[1][i]),
                            kMetresOfKm * FiniteVector(states[2][i])});
  }
  const JsonValue rotation = root.Require("body_rotation");
  RequireInertial(rotation);
  const auto attitudes =
      Columns(rotation, {"ephemeris_times", "quaternions", "angular_velocities"});
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

}  // namespace sarblock
