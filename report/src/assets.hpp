// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace bouncelab::report {

/// Files of this folder, carried inside the program.
std::string_view asset_template();
std::string_view asset_style();
std::string_view asset_plotly();
/// text.js ... page.js, in the order in which they build on each other.
std::string asset_script();

}  // namespace bouncelab::report
