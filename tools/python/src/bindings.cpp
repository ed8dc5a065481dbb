// SPDX-License-Identifier: GPL-3.0-or-later
// The module, and long work beside Python: other threads of Python run, Ctrl-C ends it, a callback sees its progress.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>

#include "arguments.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"

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

using Handler = void (*)(int);
Handler handler_of_python = nullptr;

/// Python's own handler makes it raise KeyboardInterrupt once it runs again.
extern "C" void on_interrupt(int signal) {
  request_stop();
  if (handler_of_python != nullptr) handler_of_python(signal);
}

bool is_main_thread() {
  const py::module_ threading = py::module_::import("threading");
  return threading.attr("current_thread")().is(threading.attr("main_thread")());
}

/// While it lives Ctrl-C asks the libraries to stop, where Python would take it too: on the main thread, with a handler
/// of Python's.
class Interruptible {
 public:
  Interruptible() : active_(is_main_thread()) {
    if (!active_) return;
    const Handler before = PyOS_setsig(SIGINT, on_interrupt);
    if (before == SIG_DFL || before == SIG_IGN || before == on_interrupt) {
      PyOS_setsig(SIGINT, before);
      active_ = false;
      return;
    }
    handler_of_python = before;
  }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  ~Interruptible() {
    if (!active_) return;
    PyOS_setsig(SIGINT, std::exchange(handler_of_python, nullptr));
    forget_stop_request();
  }

 private:
  bool active_;
};

/// Lets Python see the progress, now and then; it never goes back.
class Progress {
 public:
  explicit Progress(const py::object& callback) : callback_(callback) {}

  /// From any thread; what comes while another one is shown, or too soon after it, is not.
  void operator()(const std::string& label, double done, double total, const std::string& unit) {
    const std::unique_lock one(mutex_, std::try_to_lock);
    if (!one) return;
    const auto now = std::chrono::steady_clock::now();
    const bool same = label == label_;
    if (same && (done < done_ || now - last_ < std::chrono::milliseconds(50))) return;
    last_ = now;
    label_ = label, done_ = done, total_ = total, unit_ = unit;
    const py::gil_scoped_acquire lock;
    callback_(label, done, total, unit);
  }

  /// The work is done, whatever was shown of it.
  void finish() {
    if (!label_.empty() && done_ < total_) callback_(label_, total_, total_, unit_);
  }

 private:
  const py::object& callback_;
  std::mutex mutex_;
  std::string label_, unit_;
  double done_ = 0.0, total_ = 0.0;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace

void run(stages::Run& call, const py::object& progress, const std::function<void()>& work) {
  const Interruptible interruptible;
  Progress shown(progress);
  if (!progress.is_none())
    call.on_progress = [&shown](const std::string& label, double done, double total, const std::string& unit) {
      shown(label, done, total, unit);
    };
  try {
    const py::gil_scoped_release released;
    with_threads(call.common.n_threads, work);
  } catch (const Interrupted&) {
    if (PyErr_CheckSignals() == 0) PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  call.on_progress = nullptr;  // it refers to what ends here
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (!progress.is_none()) shown.finish();
}

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
