// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab {

inline constexpr double kPi = 3.14159265358979323846;

/// Gravity used throughout unless stated otherwise [m/s^2]; the default of `--gravity`.
inline constexpr double kDefaultGravity_mps2 = 9.81;

}  // namespace bouncelab
