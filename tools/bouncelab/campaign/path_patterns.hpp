// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace bouncelab::cli {

/// The regular files that a pattern names, sorted by name. `*`, `?` and `[a-z]` stand for characters of one name,
/// as in a shell; `**` stands for folders of any depth. Names that begin with a dot are passed over.
/// @param folder  that a relative pattern starts from; what is found is then relative to it too
std::vector<std::string> files_of(const std::filesystem::path& folder, const std::string& pattern);

/// Does the pattern name this path? `*` stands for any characters here, folders included.
bool names(const std::string& pattern, const std::string& path);

}  // namespace bouncelab::cli
