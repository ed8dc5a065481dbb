// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

/// The finished parts of a long run (drops of a loop, points of a sweep), appended one line at a time, so that a run
/// that was killed at any moment continues where it was.
///
/// The first line is the identity of the run, then follows one line for each finished part, each with a checksum. The
/// file is cut off behind its last complete line when it is opened: an incomplete line is never read.
class RunJournal {
 public:
  using OnFinished = std::function<void(std::string_view record)>;

  /// Opens the journal of this run, or starts one.
  /// @param on_finished  called with the record of each part that earlier runs finished
  /// @throws FileError where the file cannot be read or written, or another process has it open; InvalidArgument where
  ///         it belongs to a run with another identity, naming the first entry that differs, or was written by another
  ///         version
  RunJournal(std::filesystem::path path, const RunIdentity& identity, const OnFinished& on_finished);
  RunJournal(const RunJournal&) = delete;
  RunJournal& operator=(const RunJournal&) = delete;
  ~RunJournal();

  /// Writes the record of one part, a text without line breaks, in one piece; from any thread.
  /// @throws FileError (disk full)
  void append(std::string_view record);

  /// Closes and deletes the file: the results of the run are written.
  void remove();

 private:
  void read(const RunIdentity& identity, const OnFinished& on_finished);
  void take(const std::string& record, const OnFinished& on_finished) const;
  void write(const std::string& line);

  std::filesystem::path path_;
  int file_ = -1;
  std::mutex mutex_;
};

}  // namespace bouncelab::loop
