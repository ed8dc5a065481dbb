// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace bouncelab {

/// The name that was probably meant: the one reached by the fewest insertions, deletions, replacements and swaps of
/// neighbours, the first of several.
/// @return empty where more than a third of the longer word would have to change
std::string nearest_name(std::string_view typed, const std::vector<std::string>& names);

}  // namespace bouncelab
