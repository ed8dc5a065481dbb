// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "commands/ball_choice.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

/// --ball and --plate.
/// @param choice  its content is the default; empty: none
/// @param unnamed  what happens where they are not given, for --help: "no corrections"; empty where they have defaults
void add_ball_options(CLI::App& app, BallChoice& choice, const std::string& unnamed = "");

}  // namespace bouncelab::cli
