// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "stage_options/foreign_options.hpp"
#include "stages/files/table_reader.hpp"

namespace bouncelab::stages {

using options::ForeignFileOptions;

/// Onsets of any file: tables as detect writes them are read in pieces; marks of sound editors (Audacity, Sonic
/// Visualiser, Praat, cue points of a WAV file), and times or intervals in a table of another program, at once.
/// @param taken_for  a line is added where the file is not ours
/// @throws FileError, InvalidArgument
std::unique_ptr<TableReader> open_onsets(const std::filesystem::path& path, const ForeignFileOptions& options,
                                         std::vector<std::string>& taken_for);
/// All of them. @throws FileError, InvalidArgument
Onsets read_onsets(const std::filesystem::path& path, const ForeignFileOptions& options,
                   std::vector<std::string>& taken_for);

/// Coefficients of restitution and speeds: a table as restitution writes it, in pieces, or another's, at once.
std::unique_ptr<TableReader> open_samples(const std::filesystem::path& path, const ForeignOptions& options,
                                          std::vector<std::string>& taken_for);

/// Does the file hold times or marks, rather than sound? As audio::holds_times() says, if no rate of samples is given.
bool holds_times(const std::filesystem::path& path, bool has_rate);

}  // namespace bouncelab::stages
