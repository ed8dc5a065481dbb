// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace bouncelab::cli {

/// For each file the index of the first one with the same content, which mostly is its own. Content is compared by
/// size, then by SHA-256, which the provenance needs too. A file that cannot be read has its own content.
std::vector<std::size_t> first_of_same_content(const std::vector<std::filesystem::path>& files, int n_threads);

}  // namespace bouncelab::cli
