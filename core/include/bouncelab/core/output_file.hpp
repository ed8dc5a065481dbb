// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

namespace bouncelab {

/// A file that appears whole or not at all: written beside its final place under a hidden name, renamed by commit(),
/// removed by the destructor otherwise (an exception, Ctrl-C), or, where the process was killed, by the next process
/// that writes in that folder.
///
/// Links are followed: the file behind them is replaced, with its permissions, and they stay. What is no file ("-" for
/// standard output, /dev/stdout, /dev/fd/N, /dev/null, a device, a FIFO) is never replaced: the file is written to
/// TMPDIR or /tmp, and commit() copies it.
class OutputFile {
 public:
  /// @throws FileExists where the file exists and may not be replaced; FileError where the folder does not exist or
  ///         cannot be written, or the name is too long
  OutputFile(std::filesystem::path path, bool may_replace);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  /// Where to write until commit(); on the same file system, with the same extension (if it has at most 16 bytes). The
  /// file exists, is empty, and is to be written to, not replaced.
  const std::filesystem::path& temporary_path() const;
  /// Puts the file in its place. @throws FileError; FileExists where another process made it meanwhile
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes `content` whole or not at all. @throws FileError
void write_whole(const std::filesystem::path& path, std::string_view content, bool may_replace);

/// Closes a file that was written by a stream. @param name  for people. @throws FileError where not all was written
void close_written(std::ofstream& file, const std::filesystem::path& name);

/// "the disk is full" and the like, from errno (0: not known); names the limits that people set themselves.
std::string why_writing_failed(int error);

/// Whether an output goes to what is no file: no other file can lie beside it.
bool is_stream(const std::filesystem::path& output);
/// Whether an output goes where standard output goes.
bool is_standard_output(const std::filesystem::path& output);

/// Writes text to standard output. @return 0, or errno: EPIPE where nobody reads it any more
int write_to_standard_output(std::string_view text);

/// Deletes the hidden files that killed processes of this machine left in a folder. Done by OutputFile in its folder.
void remove_abandoned_files(const std::filesystem::path& folder);

}  // namespace bouncelab
