// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace bouncelab {

/// exp_each and log_each for processors that have AVX.
void exp_by_fours(double* x, std::size_t n);
void log_by_fours(double* x, std::size_t n);

}  // namespace bouncelab
