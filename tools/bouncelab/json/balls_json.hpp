// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace bouncelab::cli {

/// All balls, materials and plates.
std::string balls_json();

}  // namespace bouncelab::cli
