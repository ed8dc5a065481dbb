// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "bouncelab/core/onsets.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// Writes wave.json, what the report draws of a recording: its envelope, the impacts found, excerpts around some.
void write_wave(const Run& run, const std::filesystem::path& recording, int channel, const Onsets& onsets,
                const std::filesystem::path& out);

}  // namespace bouncelab::cli
