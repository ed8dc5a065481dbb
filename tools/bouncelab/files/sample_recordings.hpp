// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::cli {

/// Calls `take` with the samples of each recording of the files, in their order, and holds no more than one recording
/// and a piece of the file at a time. Samples without a recording get the file's name.
/// A recording of the same name in a later file is one of its own: `RECORDING (FILE)`. Files of the same content count
/// once.
/// @param warnings  one line for each file that is left out, and for each file whose recordings were renamed
/// @throws FileError; naming the recording whose rows are not together
void for_each_recording(const std::vector<std::filesystem::path>& files, int n_threads,
                        std::vector<std::string>& warnings, const std::function<void(RestitutionSamples&&)>& take);

}  // namespace bouncelab::cli
