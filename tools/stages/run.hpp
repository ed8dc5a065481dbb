// SPDX-License-Identifier: GPL-3.0-or-later
/// What every stage is made of, as the command line and Python call it: it takes options, calls one function of a
/// library, writes files. Nothing is computed here.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::stages {

using namespace options;  // which the page has too

/// Options that every command has.
struct CommonOptions {
  std::uint64_t seed = 1;
  int n_threads = 0;  ///< 0: all cores; results do not depend on it
  std::string config;
  bool json = false;
  bool quiet = false;
  bool force = false;
};
Description members_of(const CommonOptions*);

/// An option with the values in force.
struct Parameter {
  std::string name;  ///< without dashes in front
  std::vector<std::string> values;
  bool is_output = false;  ///< they are files or folders that are written
};
using Parameters = std::vector<Parameter>;

/// The texts of each option that was given, on the command line or in the configuration file, by its name.
using Given = std::map<std::string, std::vector<std::string>>;

/// One call of the program, as a command sees it.
struct Run {
  CommonOptions common;
  std::vector<std::string> command_line;
  Given given;
  Parameters parameters;               ///< every option of the command, resolved, for the provenance
  std::vector<std::string> arguments;  ///< of the command, those of the configuration file first
  std::vector<loop::SweepAxis> sweep;  ///< lists of the configuration file, in its order
  /// Takes the progress in place of the line on standard error: what is done, how much of it, of how much (0: not
  /// known), in what unit.
  std::function<void(const std::string& label, double done, double total, const std::string& unit)> on_progress;
};

/// What every command has.
Section common_section(CommonOptions& common);
/// Every option with its texts: those typed, else the default as it would be typed.
Parameters parameters_of(const std::vector<Section>& sections, const Given& given);
/// Replaces the value of one of them.
void set_parameter(Parameters& parameters, const std::string& name, const std::string& value);

enum ExitCode : int { kDone = 0, kNotUsable = 1, kWrongUsage = 2, kFileError = 3, kInterrupted = 130 };

/// The result of a command. Its files are written already.
struct Outcome {
  int exit_code = kDone;
  Object result;            ///< printed with --json
  std::string text;         ///< printed on standard output otherwise
  std::vector<Note> notes;  ///< their warnings are lines on standard error
  std::string error;        ///< why the result is not usable: one line on standard error, even with --quiet
};

/// Each with its line feed.
inline std::string lines_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

inline std::vector<Note> joined(std::vector<Note> notes, const std::vector<Note>& more) {
  notes.insert(notes.end(), more.begin(), more.end());
  return notes;
}

/// The result of a command that is a stage of `analyze` or `loop`, with the values that later stages need.
template <class Result>
struct Stage {
  Outcome outcome;
  Result result;
};

}  // namespace bouncelab::stages
