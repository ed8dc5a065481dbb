// SPDX-License-Identifier: GPL-3.0-or-later
/// Label tracks of Audacity: short labels, which are seen between the impacts, and all else that is known of the onsets
/// in a table beside them.
#pragma once

#include <filesystem>
#include <vector>

#include "bouncelab/audio/annotations.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// drop.txt -> drop.txt.onsets.csv
std::filesystem::path onsets_beside(const std::filesystem::path& labels);

/// What is read where these are: with the tables beside labels.
std::vector<std::filesystem::path> with_onsets_beside(std::vector<std::filesystem::path> files);

/// Writes both, of onsets of one recording.
void write_label_track(const Run& run, const std::filesystem::path& out, const Onsets& onsets,
                       const std::vector<std::filesystem::path>& inputs);

/// The labels, completed from the table beside them where there is one.
/// @throws FileError naming the place of what is faulty
audio::Annotations read_label_track(const std::filesystem::path& path, const std::string& text);

}  // namespace bouncelab::stages
