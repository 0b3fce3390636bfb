// SPDX-License-Identifier: Apache-2.0
#include "sarblock/reduction/reduction.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/frame.h"

#include <cmath>
#include <string>

#include "core/text.h"
#include "module.h"
#include "reduction/reduction.h"
#include <pybind11/numpy.h>

namespace sarblock::python {
namespace {

namespace py = pybind11;
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
