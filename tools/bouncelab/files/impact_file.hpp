// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab::cli {

/// The drops of an impacts table, read in pieces as they are asked for.
/// @throws FileError, while drops are taken
synthesis::DropSource impact_file(const std::filesystem::path& path);

}  // namespace bouncelab::cli
