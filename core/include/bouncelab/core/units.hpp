// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/elementary.hpp"

namespace bouncelab {

/// Gravity used throughout unless stated otherwise [m/s^2].
inline constexpr double kDefaultGravity_mps2 = 9.81;

}  // namespace bouncelab
