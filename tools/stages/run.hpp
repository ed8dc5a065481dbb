// SPDX-License-Identifier: GPL-3.0-or-later
/// What every stage is made of, as the command line and Python call it: it takes options, calls one function of a
/// library, writes files. Nothing is computed here.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/parallel.hpp"
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
  std::vector<loop::SweepAxis> sweep;  ///< lists of the configuration file, in its order
  /// Takes the progress in place of the line on standard error: what is done, how much of it, of how much (0: not
  /// known), in what unit.
  std::function<void(const std::string& label, double done, double total, const std::string& unit)> on_progress;
};

/// What every command has.
Section common_section(CommonOptions& common);
/// Every option with its texts: those typed, else the default as it would be typed.
Parameters parameters_of(const std::vector<Section>& sections, const Given& given);

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

/// From now on the next progress call after Ctrl-C, SIGTERM or SIGHUP throws Interrupted; a second signal, more than
/// 0.2 s later, ends the program at once. A limit of the size of files, and a pipe that nobody reads, make writing
/// fail.
void notice_signals();

/// A line on standard error with work done, rate and time left, where that is a terminal and --quiet was not given;
/// nothing otherwise; run.on_progress where that is set. Either way the callback throws Interrupted once the user asked
/// to stop.
/// @param label  what is being done ("simulate")
/// @param unit   what is counted ("drops", "s of sound")
ProgressCallback progress_line(const Run& run, const std::string& label, const std::string& unit);

/// The same for the stages of a loop.
StageProgress stage_progress(const Run& run);

}  // namespace bouncelab::stages
