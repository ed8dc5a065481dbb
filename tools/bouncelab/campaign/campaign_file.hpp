// SPDX-License-Identifier: GPL-3.0-or-later
/// What a campaign's TOML file says: one command over many recordings or settings, and how its jobs are to run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "options/toml_entries.hpp"

namespace bouncelab::cli {

/// A pattern of recordings with what belongs to them: a plate, a date.
struct PatternValue {
  std::string pattern, value;
  std::string place;  ///< "FILE: line 3"
};

/// [jobs]. What is empty or 0 is left to the cluster, or to what was measured.
struct JobSettings {
  std::int64_t n_shards = 0;          ///< 0: by measured cost
  double seconds_per_shard = 1200.0;  ///< of one shard, where their number is not given
  std::int64_t n_at_once = 0;         ///< 0: no limit on a cluster, all cores here
  std::int64_t n_cpus = 1;            ///< of a shard
  std::string partition, account, time, memory;
  std::string merge_time, merge_memory;  ///< empty: those of a shard
  std::vector<std::string> sbatch;       ///< further options, "--qos=long"
};

struct Campaign {
  std::filesystem::path file;    ///< as given
  std::filesystem::path folder;  ///< absolute, where the file lies: all paths in it are relative to that
  std::string command;
  std::string out;                      ///< as in the file
  std::vector<std::string> recordings;  ///< relative to `folder`; empty of a command that takes none
  std::vector<PatternValue> plates, dates;
  JobSettings jobs;
  TomlEntries options;  ///< sections of options of commands, as a configuration file has them

  bool takes_recordings() const { return command == "detect" || command == "analyze"; }
  /// The value of --out: of `detect` a table in the folder `out`.
  std::string command_out() const;
  /// Where the parts and all that the campaign itself writes lie, relative to `folder`.
  std::filesystem::path parts() const { return command_out() + ".parts"; }
  std::filesystem::path parts_folder() const { return folder / parts(); }
};

/// Its recordings are looked for. @throws FileError, InvalidArgument naming file, line and remedy
Campaign read_campaign(const std::filesystem::path& file);

/// The configuration file of the command: options as they stand in the campaign's, with `out` and the like.
/// @param list  of recordings; empty of a command that takes none
std::string config_text(const Campaign& campaign, const std::string& out, const std::string& list);

}  // namespace bouncelab::cli
