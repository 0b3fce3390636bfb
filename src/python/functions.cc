// SPDX-License-Identifier: Apache-2.0
// Functions of numbers alone, for arrays of them: the paper, delays of the air, the solid Earth
// tide.
#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/leberl/formulas.h"
#include "sarblock/reduction/reduction.h"

#include <cmath>
#include <map>
#include <string>

#include "core/text.h"
#include "module.h"
#include "reduction/reduction.h"
#include <pybind11/numpy.h>

namespace sarblock::python {
namespace {

namespace py = pybind11;
using leberl::Arrangement;
using leberl::StereoConfiguration;

/// What holds for all elements of the arrays.
struct Words {
  Arrangement arrangement = Arrangement::kSameSide;
  leberl::Presentation presentation = leberl::Presentation::kGroundRange;
  leberl::Signs signs = leberl::Signs::kDerived;
};

/// A function of the paper for one element: `in` begins with base, height and ground range where
/// it takes a configuration.
struct Formula {
  bool configured = true;
  py::ssize_t inputs = 0, outputs = 0;
  void (*evaluate)(const StereoConfiguration& c, const double* in, const Words&, double* out);
};

leberl::StationErrors StationOf(const double* in) {
  return {in[0], in[1], in[2], in[3], in[4], in[5]};
}

leberl::StereoErrors ErrorsOf(const double* in) { return {StationOf(in), StationOf(in + 6)}; }

// clang-format off
const std::map<std::string, Formula>& Formulas() {
  using C = StereoConfiguration;
  static const std::map<std::string, Formula> formulas{
      {"first_look_angle", {true, 3, 1, [](const C& c, const double*, const Words&, double* out) { out[0] = FirstLookAngle(c); }}},
      {"second_look_angle", {true, 3, 1, [](const C& c, const double*, const Words&, double* out) { out[0] = SecondLookAngle(c); }}},
      {"intersection_angle", {true, 3, 1, [](const C& c, const double*, const Words&, double* out) { out[0] = IntersectionAngle(c); }}},
      {"first_slant_range", {true, 3, 1, [](const C& c, const double*, const Words&, double* out) { out[0] = FirstSlantRange(c); }}},
      {"second_slant_range", {true, 3, 1, [](const C& c, const double*, const Words&, double* out) { out[0] = SecondSlantRange(c); }}},
      {"absolute_parallax", {true, 3, 1, [](const C& c, const double*, const Words& words, double* out) { out[0] = AbsoluteParallax(c, words.presentation); }}},
      {"exaggeration", {true, 3, 1, [](const C& c, const double*, const Words&, double* out) { out[0] = Exaggeration(c); }}},
      {"parallax_from_height", {true, 4, 1, [](const C& c, const double* in, const Words& words, double* out) { out[0] = ParallaxFromHeight(c, in[3], words.presentation); }}},
      {"height_from_parallax", {true, 4, 1, [](const C& c, const double* in, const Words& words, double* out) { out[0] = HeightFromParallax(c, in[3], words.presentation); }}},
      {"across_error_of_second_across", {true, 4, 1, [](const C& c, const double* in, const Words&, double* out) { out[0] = AcrossErrorOfSecondAcross(c, in[3]); }}},
      {"across_error_of_base", {true, 4, 1, [](const C& c, const double* in, const Words&, double* out) { out[0] = AcrossErrorOfBase(c, in[3]); }}},
      {"height_error_of_base", {true, 4, 1, [](const C& c, const double* in, const Words&, double* out) { out[0] = HeightErrorOfBase(c, in[3]); }}},
      {"across_error_of_height", {true, 4, 1, [](const C& c, const double* in, const Words&, double* out) { out[0] = AcrossErrorOfHeight(c, in[3]); }}},
      {"height_error_of_height", {true, 4, 1, [](const C& c, const double* in, const Words&, double* out) { out[0] = HeightErrorOfHeight(c, in[3]); }}},
      {"point_errors", {true, 15, 3, [](const C& c, const double* in, const Words& words, double* out) {
         const leberl::PointError error = PointErrors(c, ErrorsOf(in + 3), words.signs);
         out[0] = error.dx_m; out[1] = error.dy_m; out[2] = error.dz_m; }}},
      {"difference_error_of_base", {true, 6, 2, [](const C& c, const double* in, const Words& words, double* out) {
         const leberl::Difference error = DifferenceErrorOfBase(c, {in[3], in[4]}, in[5], words.signs);
         out[0] = error.dy_m; out[1] = error.dz_m; }}},
      {"difference_error_of_height", {true, 6, 2, [](const C& c, const double* in, const Words& words, double* out) {
         const leberl::Difference error = DifferenceErrorOfHeight(c, {in[3], in[4]}, in[5], words.signs);
         out[0] = error.dy_m; out[1] = error.dz_m; }}},
      {"range_warp", {true, 5, 4, [](const C& c, const double* in, const Words& words, double* out) {
         const leberl::Warp warp = RangeWarp(c, in[3], in[4], words.signs);
         out[0] = warp.a; out[1] = warp.f; out[2] = warp.c; out[3] = warp.d; }}},
      {"noise_of_range", {true, 5, 2, [](const C& c, const double* in, const Words&, double* out) {
         const leberl::RangeNoise noise = NoiseOfRange(c, in[3], in[4]);
         out[0] = noise.sigma_y_m; out[1] = noise.sigma_z_m; }}},
      {"height_displacement", {false, 2, 1, [](const C&, const double* in, const Words& words, double* out) { out[0] = leberl::HeightDisplacement(in[0], in[1], words.presentation); }}},
      {"camera_exaggeration", {false, 2, 1, [](const C&, const double* in, const Words&, double* out) { out[0] = leberl::CameraExaggeration(in[0], in[1]); }}},
      {"exaggeration_from_angles", {false, 2, 1, [](const C&, const double* in, const Words& words, double* out) { out[0] = leberl::ExaggerationFromAngles(in[0], in[1], words.arrangement); }}},
  };
  return formulas;
}
// clang-format on

py::array_t<double> Evaluate(
    const std::string& name,
    const py::array_t<double, py::array::c_style | py::array::forcecast>& inputs,
    bool opposite_side,
    bool slant_range,
    bool printed_signs) {
  const Formula& formula = Formulas().at(name);
  if (inputs.ndim() != 2 || inputs.shape(1) != formula.inputs) {
    throw InputError(name, "takes " + std::to_string(formula.inputs) + " numbers an element");
  }
  const Words words{
      opposite_side ? Arrangement::kOppositeSide : Arrangement::kSameSide,
      slant_range ? leberl::Presentation::kSlantRange : leberl::Presentation::kGroundRange,
      printed_signs ? leberl::Signs::kPrinted : leberl::Signs::kDerived};
  const py::ssize_t count = inputs.shape(0);
  py::array_t<double> out({formula.outputs, count});
  std::vector<double> values(static_cast<std::size_t>(formula.outputs));
  for (py::ssize_t i = 0; i < count; ++i) {
    const double* const in = inputs.data(i, 0);
    for (py::ssize_t k = 0; k < formula.inputs; ++k) {
      if (!std::isfinite(in[k])) {
        throw InputError(name + "[" + std::to_string(i) + "]", "a finite number is allowed");
      }
    }
    StereoConfiguration configuration;
    if (formula.configured) {
      configuration = {in[0], in[1], in[2], words.arrangement};
      Validate(configuration);
    }
    formula.evaluate(configuration, in, words, values.data());
    for (py::ssize_t k = 0; k < formula.outputs; ++k) {
      out.mutable_at(k, i) = values[static_cast<std::size_t>(k)];
    }
  }
  return out;
}

}  // namespace

void BindLeberl(py::module_* module) {
  module->def("leberl",
              &Evaluate,
              py::arg("name"),
              py::arg("inputs"),
              py::arg("opposite_side"),
              py::arg("slant_range"),
              py::arg("printed_signs"),
              "A function of Leberl (1979) for every row of (n, inputs): (outputs, n).");
}

namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

void RequireFinite(const char* field, const Numbers& inputs, py::ssize_t i) {
  for (py::ssize_t k = 0; k < inputs.shape(1); ++k) {
    if (!std::isfinite(inputs.at(i, k))) {
      throw InputError(field + ("[" + std::to_string(i) + "]"), "a finite number is allowed");
    }
  }
}

double Latitude_rad(double lat_deg) {
  if (!(std::abs(lat_deg) <= 90.0)) {
    throw InputError("lat_deg", "must be between -90 and 90, got " + NumberText(lat_deg));
  }
  return lat_deg * kRadPerDeg;
}

// Rows are height, or height, pressure, temperature, humidity, latitude and height of the weather.
py::array_t<double> ZenithDelays(const Numbers& inputs) {
  py::array_t<double> delays(inputs.shape(0));
  for (py::ssize_t i = 0; i < inputs.shape(0); ++i) {
    RequireFinite("zenith_delay", inputs, i);
    const double* const in = inputs.data(i, 0);
    delays.mutable_at(i) =
        inputs.shape(1) == 1
            ? ZenithDelay_m(in[0])
            : ZenithDelay_m(Weather{in[1], in[2], in[3], in[5]}, Latitude_rad(in[4]), in[0]);
  }
  return delays;
}

py::array_t<double> SolidEarthTides(const std::string& utc, const Numbers& inputs) {
  const TidalBodies bodies = TidalBodiesAt(utc);
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  py::array_t<double> displacements({inputs.shape(0), py::ssize_t{3}});
  for (py::ssize_t i = 0; i < inputs.shape(0); ++i) {
    RequireFinite("solid_earth_tide", inputs, i);
    const double* const in = inputs.data(i, 0);
    const Eigen::Vector3d position_m =
        frame.FrameFromGeodetic({Latitude_rad(in[0]), in[1] * kRadPerDeg, in[2]});
    const Eigen::Vector3d enu_m =
        frame.EnuFromFrame(position_m) * SolidEarthTide_m(bodies, position_m);
    for (py::ssize_t k = 0; k < 3; ++k) displacements.mutable_at(i, k) = enu_m[k];
  }
  return displacements;
}

}  // namespace

void BindReduction(py::module_* module) {
  module->def("zenith_delay", &ZenithDelays, py::arg("inputs"), "Zenith delay of every row [m].");
  module->def("solid_earth_tide",
              &SolidEarthTides,
              py::arg("utc"),
              py::arg("inputs"),
              "East, north, up [m] of every row latitude, longitude [deg], height [m]: (n, 3).");
}

}  // namespace sarblock::python
