// SPDX-License-Identifier: GPL-3.0-or-later
// The module, and long work beside Python: other threads of Python run, Ctrl-C and other signals end it, a callback
// sees its progress.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "arguments.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::python {
namespace {

/// With errno Python chooses the class: FileNotFoundError, IsADirectoryError, PermissionError ...
void raise_file_error(const FileError& error, const std::string& remedy) {
  if (error.system_error() == 0) return PyErr_SetString(PyExc_OSError, with_keywords(error.what()).c_str());
  const py::object made =
      py::handle(PyExc_OSError)(error.system_error(), with_keywords(error.reason()) + remedy, error.path());
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
}

/// What is wrong with an argument is a ValueError, with a file an OSError.
void translate(const std::exception_ptr& failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const InvalidArgument& error) {
    PyErr_SetString(PyExc_ValueError, with_keywords(error.what()).c_str());
  } catch (const FileError& error) {
    raise_file_error(error, error.system_error() == EEXIST ? "; force=True replaces it" : "");
  } catch (const Interrupted&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  } catch (const std::filesystem::filesystem_error& error) {
    raise_file_error({error.path1().string(), error.code().message(), error.code().value()}, "");
  }
}

/// Does work on a thread of its own, while this one runs the handlers of signals that come, as Python's main thread
/// does: what one raises, as that of Ctrl-C does, asks the work to stop.
/// @throws what work threw, or py::error_already_set with what a handler raised
void beside_signals(const std::function<void()>& work) {
  std::packaged_task<void()> task(work);
  std::future<void> done = task.get_future();
  std::optional<py::error_already_set> raised;
  {
    const py::gil_scoped_release released;
    std::jthread worker;
    try {
      worker = std::jthread(std::ref(task));
    } catch (const std::system_error&) {
      task();  // the system starts no more threads
    }
    while (done.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
      const py::gil_scoped_acquire lock;
      if (PyErr_CheckSignals() == 0) continue;
      raised.emplace();
      request_stop();
      const py::gil_scoped_release waiting;
      done.wait();
      forget_stop_request();
      break;
    }
  }
  if (raised) throw std::move(*raised);
  done.get();
}

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
  Progress shown(progress);
  if (!progress.is_none())
    call.on_progress = [&shown](const std::string& label, double done, double total, const std::string& unit) {
      shown(label, done, total, unit);
    };
  beside_signals([&] { with_threads(call.common.n_threads, work); });
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
  m.def("with_keywords", py::overload_cast<const std::string&>(&with_keywords));
  bind_stages(m);
  bind_fits(m);
}

}  // namespace bouncelab::python
