// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "command.hpp"

namespace bouncelab::cli {

/// The finished parts of a long run (drops of a loop, points of a sweep), appended one line at a time, so that a run
/// that was killed at any moment goes on where it was.
///
/// First line: the identity of the run. Then a line for each finished part: JSON, a tab, the beginning of its SHA-256.
/// The tail behind the last line that is whole is cut off when the journal is opened: no half line is ever read.
class RunJournal {
 public:
  using OnFinished = std::function<void(const Json& part)>;

  /// Opens the journal of this run, or starts one.
  /// @param identity     all that the parts depend on
  /// @param on_finished  called with each part that earlier calls of the program finished
  /// @throws FileError where the file cannot be read or written, or another process has it open; InvalidArgument where
  ///         it belongs to a run with another identity, naming the first thing that differs
  RunJournal(std::filesystem::path path, const Json& identity, const OnFinished& on_finished);
  RunJournal(const RunJournal&) = delete;
  RunJournal& operator=(const RunJournal&) = delete;
  ~RunJournal();

  /// Writes one part in one piece; from any thread. @throws FileError (disk full)
  void append(const Json& part);

  /// Closes and deletes the file: the run's results are written.
  void remove();

 private:
  void read(const Json& identity, const OnFinished& on_finished);
  void write(const std::string& line);

  std::filesystem::path path_;
  int file_ = -1;
  std::mutex mutex_;
};

}  // namespace bouncelab::cli
