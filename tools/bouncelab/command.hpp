// SPDX-License-Identifier: GPL-3.0-or-later
/// What every command of the command line is made of. A command registers its options, fills a struct, calls one
/// function of a room, writes files. Nothing is computed here.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace bouncelab::cli {

using Json = nlohmann::ordered_json;

/// Options that every command has.
struct CommonOptions {
  std::uint64_t seed = 1;
  int n_threads = 0;  ///< 0: all cores; results do not depend on it
  std::string config;
  bool json = false;
  bool quiet = false;
  bool force = false;
};

/// An option that is to run through several values.
struct SweepAxis {
  std::string option;  ///< without dashes in front
  std::vector<std::string> values;
};

/// One call of the program, as a command sees it.
struct Run {
  CommonOptions common;
  std::vector<std::string> command_line;
  Json parameters;                     ///< every option of the command, resolved, for the provenance
  std::vector<std::string> arguments;  ///< of the command, those of the configuration file first
  std::vector<SweepAxis> sweep;        ///< lists of the configuration file, in its order
};

enum ExitCode : int { kDone = 0, kNotUsable = 1, kWrongUsage = 2, kFileTrouble = 3, kInterrupted = 130 };

/// What a command has to say. Files are written already.
struct Outcome {
  int exit_code = kDone;
  Json summary = Json::object();      ///< printed with --json
  std::string text;                   ///< printed on standard output otherwise
  std::vector<std::string> warnings;  ///< one line each, on standard error
  std::string trouble;                ///< why the result is not usable: one line on standard error, --quiet or not
};

/// A command as main knows it.
struct Command {
  CLI::App* app = nullptr;
  std::function<Outcome(Run&)> run;
};

}  // namespace bouncelab::cli
