// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bouncelab {

/// Where a program lies on PATH; nothing where it is not installed.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// Another program that is running, without a shell: what it writes to standard output is read here, a piece at a time.
/// Its standard input is empty. It is ended with this object.
class ProgramOutput {
 public:
  /// The descriptor under which the program finds the file that is handed over to it: /dev/fd/3.
  static constexpr int kHandedOver = 3;

  /// @param arguments   without the program's name
  /// @param file        that it is to read, or what it is for, for messages
  /// @param descriptor  open for reading, handed over; stays open here; -1: none
  /// @param cpu_s       processor time after which it is ended; 0: no limit
  /// @param is_group    what it starts belongs to it, apart from this process: all are asked to end (SIGTERM) with
  ///                    this object, and Ctrl-C does not reach them before
  /// @throws FileError where it cannot be started
  ProgramOutput(const std::filesystem::path& program, std::vector<std::string> arguments, std::string file,
                int descriptor, double cpu_s, bool is_group = false);
  ProgramOutput(const ProgramOutput&) = delete;
  ProgramOutput& operator=(const ProgramOutput&) = delete;
  ~ProgramOutput();

  /// Waits until all of `out` is filled or the program has closed its output. @return bytes read.
  /// @throws FileError; Interrupted once a stop was requested
  std::size_t read(std::span<std::byte> out);
  /// After the end of its output: waits for the end of the program. @return whether it ended well (exit code 0)
  bool ended_well();
  /// The first lines that it wrote to standard error.
  const std::string& complaints() const { return complaints_; }

 private:
  void take_complaints();

  std::string file_;
  pid_t child_ = -1;
  bool is_group_ = false;
  int output_ = -1, errors_ = -1;
  std::string complaints_;
};

/// All that a program writes; it has not ended well where that is `most_bytes` or more. @throws FileError, Interrupted
struct ProgramResult {
  bool ended_well = false;
  std::string output, complaints;
};
ProgramResult run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const std::string& file, int descriptor, double cpu_s, std::size_t most_bytes = 1 << 16);

}  // namespace bouncelab
