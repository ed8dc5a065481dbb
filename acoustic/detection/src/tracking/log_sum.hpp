// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {

/// log(exp(a) + exp(b)), for any log odds: their exponentials may be beyond a double's range.
inline double log_of_sum(double a, double b) { return std::max(a, b) + log1p(exp(-std::abs(a - b))); }

/// The exponent of x > 0 as a power of two. The C library's ilogb is a call.
inline int binary_exponent(double x) { return static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52) - 1023; }

/// No less than log(x), without taking it; of what is not a number no more than of 0.
inline double largest_log(double x) {
  return x > 0.0 ? std::numbers::ln2 * (binary_exponent(x) + 1) : -std::numeric_limits<double>::infinity();
}

}  // namespace bouncelab::detection
