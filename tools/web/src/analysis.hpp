// SPDX-License-Identifier: GPL-3.0-or-later
/// What the page asks for, with the texts of the command line's files. All throw what the commands throw, and
/// InvalidArgument or FileError where a command has no result that could be shown.
#pragma once

#include <string>

#include "sound.hpp"

namespace bouncelab::web {

/// As `bouncelab detect --json`, with `onsets`, an array of the rows of onsets.csv.
std::string detect(const Sound& sound, const std::string& options_json);

struct Analysis {
  std::string summary, onsets_csv, samples_csv, fit_json, wave_json, report_html, labels;
};
/// As `bouncelab analyze`.
Analysis analyze(const Sound& sound, const std::string& options_json);
/// The same of onsets that are given.
Analysis analyze_onsets(const std::string& onsets_csv, const Sound& sound, const std::string& options_json);

}  // namespace bouncelab::web
