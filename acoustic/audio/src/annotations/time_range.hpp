// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <string>

#include "annotations/number_text.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {

inline constexpr double kLongest_s = 1e9;  // 30 years: what is beyond is a damaged file, not a mark

/// A mark's time, if it can be one: finite and within 1e9 s. @throws FileError naming the place
inline double checked_time(double t_s, const std::string& name, const std::string& place) {
  if (!(std::abs(t_s) <= kLongest_s))
    throw FileError(name, place + ": a time of " + number_text(t_s) + " s; times are within 1e9 s");
  return t_s;
}

}  // namespace bouncelab::audio
