// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::stages {

/// Samples of several files, one after the other. Of more than one file:
///   - samples without a recording get the file's name, with its folder where two files have the same name
///   - the same drop of the same recording in two files is of two recordings: the file is added to the name in both,
///     for all samples of that recording
///   - files of the same content count once
/// @param columns    of tables that are not ours: ForeignOptions::columns
/// @param taken_for  a line for each of those
/// @param warnings  one line for each file that was left out and each recording that was renamed
/// @throws FileError
RestitutionSamples read_sample_files(const std::vector<std::filesystem::path>& files, int n_threads,
                                     const std::string& columns, std::vector<std::string>& taken_for,
                                     std::vector<std::string>& warnings);

/// Calls `take` with the samples of each recording of the files, in their order, and holds no more than one recording
/// and a piece of the file at a time. Samples without a recording get the file's name.
/// A recording of the same name in a later file is one of its own: `RECORDING (FILE)`. Files of the same content count
/// once.
/// @param warnings  one line for each file that is left out, and for each file whose recordings were renamed
/// @throws FileError; naming the recording whose rows are not together
void for_each_recording(const std::vector<std::filesystem::path>& files, int n_threads,
                        std::vector<std::string>& warnings, const std::function<void(RestitutionSamples&&)>& take);

}  // namespace bouncelab::stages
