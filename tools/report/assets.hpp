// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace bouncelab::report {

/// Files of this folder, carried inside the program.
std::string_view asset_template();
std::string_view asset_style();
std::string_view asset_paper();
std::string_view asset_sweep();
std::string_view asset_script();
std::string_view asset_plotly();

}  // namespace bouncelab::report
