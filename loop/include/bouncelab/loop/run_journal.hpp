// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bouncelab::loop {

/// All that the parts of a run depend on: names and values, in a fixed order.
using RunIdentity = std::vector<std::pair<std::string, std::string>>;

/// The name of the first entry in which two identities differ, with both values.
std::string first_difference(const RunIdentity& before, const RunIdentity& now);

/// The finished items of a long run (drops of a loop, points of a sweep, recordings), appended one line at a time, so
/// that a run that was killed at any moment continues where it was.
///
/// The first line is the identity of the run, then follows one line for each finished item, its name and its record,
/// each line with a checksum. The file is cut off behind its last complete line when it is opened: an incomplete line
/// is never read. An item may have several lines: the last one counts.
class RunJournal {
 public:
  using OnFinished = std::function<void(const std::string& item, std::string_view record)>;

  /// Opens the journal of this run, or starts one.
  /// @param on_finished  called with each item that earlier runs finished, and its record
  /// @throws FileError where the file cannot be read or written, or another process has it open; InvalidArgument where
  ///         it belongs to a run with another identity, naming the first entry that differs, or was written by another
  ///         version
  RunJournal(std::filesystem::path path, const RunIdentity& identity, const OnFinished& on_finished);
  RunJournal(const RunJournal&) = delete;
  RunJournal& operator=(const RunJournal&) = delete;
  ~RunJournal();

  /// Writes the record of one item in one piece; from any thread.
  /// @param item    its name in this run, any text
  /// @param record  a text without line breaks
  /// @throws FileError (disk full)
  void append(const std::string& item, std::string_view record);

  /// Closes and deletes the file: the results of the run are written.
  void remove();

 private:
  void read(const RunIdentity& identity, const OnFinished& on_finished);
  void write(const std::string& line);

  std::filesystem::path path_;
  int file_ = -1;
  std::mutex mutex_;
};

/// An item in a journal that nobody writes to any more.
struct JournalEntry {
  std::string item;
  std::int64_t first_byte = 0;  ///< of its record in the file
  std::int64_t n_bytes = 0;
};
struct ReadJournal {
  RunIdentity identity;
  std::vector<JournalEntry> entries;  ///< in their order; several of one item are possible
};

/// Reads a journal as far as its lines are complete, and leaves it as it is.
/// @throws FileError where it cannot be read or is no journal
ReadJournal read_journal(const std::filesystem::path& path);

}  // namespace bouncelab::loop
