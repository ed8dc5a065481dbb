// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::cli {

/// Samples of several files, one after the other. Of more than one file:
///   - samples without a recording get the file's name, with its folder where two files have the same name
///   - the same drop of the same recording in two files is of two recordings: the file is added to the name in both,
///     for all samples of that recording
///   - files of the same content count once
/// @param warnings  one line for each file that was left out and each recording that was renamed
/// @throws FileError
RestitutionSamples read_sample_files(const std::vector<std::filesystem::path>& files, int n_threads,
                                     std::vector<std::string>& warnings);

}  // namespace bouncelab::cli
