// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <filesystem>
#include <string>

#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "stages.hpp"
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
  m.def("simulate", &simulate);
  m.def("synthesize", &synthesize);
  m.def("detect_files", &detect_files);
  m.def("detect_samples", &detect_samples);
  m.def("restitution", &restitution);
  m.def("onsets_of_heights", &onsets_of_heights);
  m.def("wave_of_file", &wave_of_file);
  m.def("wave_of_samples", &wave_of_samples);
  m.def("write_sound", &write_sound);
  m.def("write_columns", &write_columns);
  m.def("read_columns", &read_columns);
  m.def("fit", &fit);
  m.def("roughness", &roughness);
  m.def("loop", &loop);
  m.def("score_detector", &score_detector);
  m.def("restitution_of_law", &restitution_of_law);
  m.def("scatter", &scatter);
  m.def("sides_of_fluctuation", &sides_of_fluctuation);
  m.def("write_report", &write_report);
}

}  // namespace bouncelab::python
