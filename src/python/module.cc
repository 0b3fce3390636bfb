// SPDX-License-Identifier: Apache-2.0
#include "module.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/leberl/formulas.h"
#include "sarblock/reduction/reduction.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "arrays.h"
#include "core/text.h"
#include "reduction/reduction.h"
#include <glog/logging.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace sarblock::python {
namespace {

namespace py = pybind11;

// Functions of numbers alone, for arrays of them: the paper, delays of the air, the solid Earth
// tide.

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

void BindReduction(py::module_* module) {
  module->def("zenith_delay", &ZenithDelays, py::arg("inputs"), "Zenith delay of every row [m].");
  module->def("solid_earth_tide",
              &SolidEarthTides,
              py::arg("utc"),
              py::arg("inputs"),
              "East, north, up [m] of every row latitude, longitude [deg], height [m]: (n, 3).");
}

// The module.

/// Exceptions of the module; they live as long as the process.
struct Exceptions {
  PyObject* input = nullptr;
  PyObject* undetermined = nullptr;
  PyObject* interrupted = nullptr;
};
Exceptions g_exceptions;

PyObject* AddException(py::module_* module, const char* name, PyObject* base, const char* help) {
  PyObject* const type =
      PyErr_NewExceptionWithDoc((std::string("sarblock.") + name).c_str(), help, base, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module->attr(name) = py::reinterpret_borrow<py::object>(type);
  return type;
}

void AddExceptions(py::module_* module) {
  g_exceptions.input = AddException(
      module,
      "InputError",
      PyExc_ValueError,
      "Input that cannot be used: a file, a table, an array or an option. The message names the "
      "place, what is wrong and what is allowed, in the words of the command line. Where it is of "
      "a file or a block: `file`, `line` (0 for the whole file), `field`, `problem`.");
  const auto input = py::reinterpret_borrow<py::object>(g_exceptions.input);
  for (const char* name : {"file", "field", "problem"}) input.attr(name) = "";
  input.attr("line") = 0;
  g_exceptions.undetermined = AddException(
      module,
      "UndeterminedError",
      PyExc_RuntimeError,
      "A block that its observations do not determine. `names` is the list of the parameters and "
      "points that cannot be known, `diagnosis` the sentences on what the cause may be, the most "
      "likely "
      "first (empty where none was found or `diagnose` is off).");
  g_exceptions.interrupted = AddException(module,
                                          "Interrupted",
                                          PyExc_KeyboardInterrupt,
                                          "Ctrl-C ended a call; nothing is left half written.");
}

void Raise(PyObject* type, const char* text) { PyErr_SetObject(type, TextObject(text).ptr()); }

void RaiseUndetermined(const UndeterminedError& error, const std::vector<std::string>& sentences) {
  const auto type = py::reinterpret_borrow<py::object>(g_exceptions.undetermined);
  const py::object raised = type(TextObject(error.what()));
  raised.attr("names") = TextList(error.names());
  raised.attr("diagnosis") = TextList(sentences);
  if (py::hasattr(raised, "add_note")) {  // from Python 3.11 on a traceback shows them
    for (const std::string& sentence : sentences) raised.attr("add_note")(TextObject(sentence));
  }
  PyErr_SetObject(g_exceptions.undetermined, raised.ptr());
}

void Translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const InputError& error) {
    const auto type = py::reinterpret_borrow<py::object>(g_exceptions.input);
    const py::object raised = type(TextObject(error.what()));
    raised.attr("file") = TextObject(error.place().file);
    raised.attr("line") = error.place().line;
    raised.attr("field") = TextObject(error.place().field);
    raised.attr("problem") = TextObject(error.problem());
    PyErr_SetObject(g_exceptions.input, raised.ptr());
  } catch (const ExplainedRefusal& error) {
    RaiseUndetermined(error, error.sentences());
  } catch (const UndeterminedError& error) {
    RaiseUndetermined(error, {});
  } catch (const Interrupted& error) {
    Raise(g_exceptions.interrupted, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    PyErr_SetString(
        PyExc_OSError,
        (error.path1().string() + ": cannot be used: " + error.code().message()).c_str());
  }
}

py::list OptionTable() {
  py::list out;
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    out.append(py::make_tuple(std::string(option.key),
                              std::string(option.type),
                              std::string(option.allowed),
                              std::string(option.standard),
                              std::string(option.help)));
  }
  return out;
}

}  // namespace

}  // namespace sarblock::python

PYBIND11_MODULE(_core, module) {
  using namespace sarblock::python;
  FLAGS_minloglevel = google::GLOG_ERROR;
  module.doc() = "The compiled part of sarblock.";
  module.attr("__version__") = sarblock::Version();
  AddExceptions(&module);
  EndWorkWithInterpreter();
  pybind11::register_exception_translator(&Translate);
  BindBlock(&module);
  BindResult(&module);
  BindLeberl(&module);
  BindReduction(&module);
  module.def("option_table",
             &OptionTable,
             "The keys of [adjust]: key, type, what is allowed, standard, help.");
}
