// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {

/// log(exp(a) + exp(b)), for any log odds: their exponentials may be beyond a double's range.
inline double log_of_sum(double a, double b) { return std::max(a, b) + log1p(exp(-std::abs(a - b))); }

}  // namespace bouncelab::detection
