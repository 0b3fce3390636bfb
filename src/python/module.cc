// SPDX-License-Identifier: Apache-2.0
#include "module.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"

#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "arrays.h"
#include <glog/logging.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace sarblock::python {
namespace {

namespace py = pybind11;

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
