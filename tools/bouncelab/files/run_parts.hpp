// SPDX-License-Identifier: GPL-3.0-or-later
/// A run in several parts, each by a process of its own, on one machine or on many. `COMMAND ... --shard 3/8` does
/// every eighth item of the run and keeps the items' records in OUT.parts/shard-3-of-8.part; `bouncelab merge` puts the
/// records of all parts together.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "bouncelab/core/file_bytes.hpp"
#include "bouncelab/loop/run_journal.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// All that the records of a run depend on: the program's version, every option but those that only choose how to run,
/// and the files that it reads, by content.
/// @param left_out  options on which records do not depend: inputs that are items of their own, for instance
loop::RunIdentity run_identity(const Run& run, const std::vector<std::filesystem::path>& inputs,
                               const std::vector<std::string>& left_out = {});

/// Whether the record of an item still stands for it; an item's input may have changed.
using IsCurrent = std::function<bool(const std::string& item, std::string_view record)>;

/// The items of one part, and their records: OUT.parts/shard-I-of-N.unfinished, which after all of them is called
/// OUT.parts/shard-I-of-N.part. A process that was killed left what it had finished.
class PartFile {
 public:
  /// @param run    has a shard
  /// @param items  of the whole run, each name once
  /// @throws FileError where the part is at work already, or cannot be written; InvalidArgument where it is that of a
  ///         run with other settings
  PartFile(const Run& run, const std::filesystem::path& out, const loop::RunIdentity& identity,
           const std::vector<std::string>& items, const IsCurrent& is_current = {});

  /// The items to be done, by their places in the run.
  const std::vector<std::size_t>& pending() const { return pending_; }
  bool is_pending(const std::string& item) const { return pending_names_.contains(item); }
  /// Whether an earlier process began it.
  bool goes_on() const { return goes_on_; }
  /// From any thread.
  void keep(std::size_t item, std::string_view record);
  loop::RunJournal& journal() { return *journal_; }

  /// All items are done: gives the part its name, and provenance beside it.
  /// @param inputs  that were read
  /// @param unit    of the items, in the plural: "recordings"
  Outcome finish(const std::vector<std::filesystem::path>& inputs, const std::string& unit);

 private:
  void take_from_other_parts(const loop::RunIdentity& identity, const IsCurrent& is_current);

  const Run& run_;
  std::filesystem::path part_, unfinished_;
  std::vector<std::string> items_;
  std::size_t n_own_ = 0;
  bool goes_on_ = false;
  std::vector<std::size_t> pending_;
  std::unordered_set<std::string> pending_names_;
  std::unique_ptr<loop::RunJournal> journal_;
};

/// The records of all items of a run, from its parts.
class RunParts {
 public:
  /// @param run  has parts: their files
  /// @throws InvalidArgument where a part is of a run with other settings, or an item has no record, naming the shards
  ///         that are missing; FileError
  RunParts(const Run& run, const loop::RunIdentity& identity, const std::vector<std::string>& items);

  std::size_t size() const { return places_.size(); }
  /// Read from the file at each call.
  std::string record(std::size_t item);

 private:
  struct Place {
    std::size_t file = 0;
    std::int64_t first_byte = 0, n_bytes = 0;
  };
  std::vector<std::filesystem::path> paths_;
  std::size_t open_ = 0;  ///< place in paths_ of the file that is open
  std::unique_ptr<FileBytes> file_;
  std::vector<Place> places_;
};

/// What a part says of its run, so that it can be put together without being told.
struct AboutRun {
  std::string command;
  std::vector<std::string> arguments;  ///< those of the configuration file too, without the shard
  std::vector<loop::SweepAxis> sweep;
  std::filesystem::path folder;  ///< in which it ran
};
/// @throws FileError where the file is no part
AboutRun about_run(const std::filesystem::path& part);

/// The part files among these files and folders, by name.
/// @throws FileError where there is none, or one is not finished
std::vector<std::filesystem::path> part_files(const std::vector<std::filesystem::path>& given);

}  // namespace bouncelab::cli
