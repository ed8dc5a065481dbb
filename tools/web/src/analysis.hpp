// SPDX-License-Identifier: GPL-3.0-or-later
/// What the page asks for. All throw InvalidArgument or FileError where there is no result that could be shown.
#pragma once

#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "bouncelab/loop/analyze.hpp"
#include "bouncelab/report/answer.hpp"
#include "sound.hpp"

namespace bouncelab::web {

/// Impacts of the sound. @return one recording
std::vector<detection::RecordingDetection> detect(const Sound& sound, const std::string& options_json);

/// An analysis of one sound with what is said of it.
struct Analysis {
  loop::Analysis found;
  report::FitInWords words;
  Object summary;  ///< as summary.json
  std::string name_of_file;
  std::string taken_for;  ///< what a file that is not ours was taken for

  /// Files that the command line would leave: onsets.csv, samples.csv, fit.json, wave.json, report.html, labels.txt.
  std::string file(const std::string& name) const;
};
/// @throws InvalidArgument where no impact was found
Analysis analyze(const Sound& sound, const std::string& options_json);
/// Is it a file of times or marks, rather than of sound?
bool holds_times(const std::string& bytes);
/// The same of a file of times, intervals or marks from any program, without sound. Options as, unit, columns, tier.
/// @throws AmbiguousTable
Analysis analyze_times(const std::string& bytes, const std::string& name, const std::string& options_json);
/// The same of impacts that are given.
Analysis analyze_onsets(Onsets onsets, const Sound& sound, const std::string& options_json);

}  // namespace bouncelab::web
