// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bouncelab/core/ball.hpp"

namespace bouncelab::cli {

/// What was understood of --ball.
nlohmann::ordered_json ball_json(const Ball& ball);
/// Likewise of --plate.
nlohmann::ordered_json plate_json(const Material& plate);

/// All balls, materials and plates.
std::string balls_json();

}  // namespace bouncelab::cli
