// SPDX-License-Identifier: GPL-3.0-or-later
/// Long work beside Python: other threads of Python run, Ctrl-C ends it, a callback sees its progress.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>

#include "stages/run.hpp"

namespace bouncelab::python {

namespace py = pybind11;

/// Runs work() without the interpreter's lock, with the threads that the call asks for.
/// @param call      gets a callback for its progress
/// @param progress  called as progress(label, done, total, unit), at most every 50 ms, from one thread at a time, and
/// at
///                  the end with done = total; None: not called.
///                  What it throws ends the work
/// @throws py::error_already_set KeyboardInterrupt after Ctrl-C, where this is the main thread; what work throws
void run(stages::Run& call, const py::object& progress, const std::function<void()>& work);

}  // namespace bouncelab::python
