// SPDX-License-Identifier: GPL-3.0-or-later
/// What the page asks for. All throw InvalidArgument or FileError where there is no result that could be shown.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/loop/analyze.hpp"
#include "bouncelab/report/answer.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::web {

/// A recording in memory; samples interleaved, full scale = 1.
struct Sound {
  std::vector<float> samples;
  double rate_hz = 0.0;
  int n_channels = 0;
  std::string name, format, lossy_coding;
  std::vector<std::string> warnings;
};

/// Of the bytes of a file of this name, by the reader of the command line; no ffmpeg. @throws FileError
Sound read_sound(const std::string& bytes, const std::string& name);
/// The last part of a recording's name; "recording" where there is none.
std::string file_name(const std::string& name);

/// The seed, which every stage has.
struct Seed {
  std::uint64_t seed = 1;
};
Description members_of(const Seed*);

/// Sets options from a JSON object: {"ball": "steel:6mm", "drop_height_m": 0.5, "air": 1.2}; names as on the
/// command line without the dashes in front, '_' is '-', and a unit at the end may stand (drop_height_m, gravity_mps2).
/// Lists are values with commas.
/// @throws InvalidArgument naming the option
void set_options(const std::vector<options::Section>& sections, const std::string& json);

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
/// The same of a file of times, intervals, heights, speeds or marks from any program, without sound. Options as, unit,
/// columns, tier.
/// @throws AmbiguousTable
Analysis analyze_times(const std::string& bytes, const std::string& name, const std::string& options_json);
/// The same of impacts that are given.
Analysis analyze_onsets(Onsets onsets, const Sound& sound, const std::string& options_json);

struct Simulation {
  Table impacts, truth;
  std::string law_json;
  Sound sound;
};
/// As `bouncelab simulate` and `bouncelab synthesize`, whose options are taken together.
Simulation simulate(const std::string& options_json);

/// p(eps) in the windows of speed of the fit: of drops simulated without sound, counted in bins, beside the closed form
/// (docs/physics.md, section 7), in which nothing is fitted.
/// @param options_json  those of simulate()
/// @return JSON: `theory` as in a loop's summary.json (docs/formats.md) with `n_drops`, `smooth_share`, the share of
///         contacts with the smooth sphere between the asperities, and, of each density, `eps_edges`, `v_lo_mps`,
///         `v_hi_mps`; without densities, and nothing simulated, where more than a tenth are smooth or the closed form
///         does not apply otherwise
std::string scatter(const std::string& options_json);

}  // namespace bouncelab::web
