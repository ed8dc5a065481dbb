// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numbers>

namespace bouncelab {

inline constexpr double kPi = std::numbers::pi;

/// Gravity used throughout unless stated otherwise [m/s^2].
inline constexpr double kDefaultGravity_mps2 = 9.81;

}  // namespace bouncelab
