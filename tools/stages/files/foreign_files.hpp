// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"
#include "stage_options/options.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

using options::ForeignFileOptions;

// Label tracks of Audacity: short labels, which are seen between the impacts, and all else that is known of the onsets
// in a table beside them.

/// drop.txt -> drop.txt.onsets.csv
std::filesystem::path onsets_beside(const std::filesystem::path& labels);

/// What is read where these are: with the tables beside labels.
std::vector<std::filesystem::path> with_onsets_beside(std::vector<std::filesystem::path> files);

/// Writes both, of onsets of one recording.
void write_label_track(const Run& run, const std::filesystem::path& out, const Onsets& onsets,
                       const std::vector<std::filesystem::path>& inputs);

/// Onsets of any file: tables as detect writes them are read in pieces; marks of sound editors (Audacity, Sonic
/// Visualiser, Praat, cue points of a WAV file), and times or intervals in a table of another program, at once.
/// @param taken_for  a line is added where the file is not ours
/// @throws FileError, InvalidArgument
TableReader open_onsets(const std::filesystem::path& path, const ForeignFileOptions& options,
                        std::vector<std::string>& taken_for);
/// All of them. @throws FileError, InvalidArgument
Onsets read_onsets(const std::filesystem::path& path, const ForeignFileOptions& options,
                   std::vector<std::string>& taken_for);

/// Coefficients of restitution and speeds: a table as restitution writes it, in pieces, or another's, at once.
TableReader open_samples(const std::filesystem::path& path, const ForeignOptions& options,
                         std::vector<std::string>& taken_for);

/// Lines of what files were taken for, those of files that were taken for the same made one: "a.csv, b.csv, c.csv and
/// 22 more: times in s (column 't (s)', ',' between)". What was counted in each is left out then.
std::vector<std::string> one_a_kind(const std::vector<std::string>& taken_for);

/// Does a table hold speeds, with coefficients of restitution or with the speeds after the bounces, rather than times?
/// By --columns, our own titles, or units of speed and none of time or length.
bool holds_speeds(const std::filesystem::path& path, const ForeignOptions& options);

/// Does the file hold times or marks, rather than sound? As audio::holds_times() says, if no rate of samples is given.
bool holds_times(const std::filesystem::path& path, bool has_rate);

}  // namespace bouncelab::stages
