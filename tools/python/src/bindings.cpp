// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <filesystem>
#include <string>

#include "arguments.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "stages/ball_of_files.hpp"

namespace bouncelab::python {
namespace {

/// What is wrong with an argument is a ValueError, with a file an OSError.
void translate(const std::exception_ptr& failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const InvalidArgument& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  } catch (const FileExists& error) {
    PyErr_SetString(PyExc_FileExistsError, (std::string(error.what()) + "; force=True replaces it").c_str());
  } catch (const FileError& error) {
    PyErr_SetString(PyExc_OSError, error.what());
  } catch (const Interrupted&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  } catch (const std::filesystem::filesystem_error& error) {
    PyErr_SetString(PyExc_OSError, (error.path1().string() + ": " + error.code().message()).c_str());
  }
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "What the package bouncelab is made of; no interface of its own.";
  py::register_exception_translator([](std::exception_ptr failure) {  // NOLINT(performance-unnecessary-value-param)
    translate(failure);
  });
  m.def("version", [] { return std::string(version()); });
  m.def("commit", [] { return std::string(commit()); });
  m.def("balls", [] { return json_text(stages::catalogue(), 2); });
  m.def("options", &options_json);
  bind_stages(m);
  bind_fits(m);
}

}  // namespace bouncelab::python
