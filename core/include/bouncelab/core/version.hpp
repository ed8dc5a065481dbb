// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace bouncelab {

/// Version of the release, e.g. "0.1.0".
std::string_view version();
/// Commit the build was configured from, short hash, "+" appended where the tree had changes; "unknown" outside git.
std::string_view commit();

}  // namespace bouncelab
