// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "command.hpp"

namespace bouncelab::cli {

Command add_calibrate_command(CLI::App& app);

}  // namespace bouncelab::cli
