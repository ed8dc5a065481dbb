// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace bouncelab {

/// Called now and then by long computations, from one thread at a time, with the work done so far and in all (same
/// unit, e.g. drops or seconds of sound; total 0 = not known). May throw Interrupted to stop the computation.
using ProgressCallback = std::function<void(double done, double total)>;

}  // namespace bouncelab
