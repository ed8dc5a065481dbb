// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bouncelab {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kHasAddressSanitizer = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool kHasAddressSanitizer = true;
#else
constexpr bool kHasAddressSanitizer = false;
#endif
#else
constexpr bool kHasAddressSanitizer = false;
#endif

/// Whether a process that has other threads may start a child that runs a function: not with the address sanitizer,
/// whose allocator keeps its locks over the fork, so that the child may wait for ever.
constexpr bool kMayStartChildBesideThreads = !kHasAddressSanitizer;

/// What a child process may use.
struct ChildLimits {
  double cpu_s = 0.0;  ///< processor time of a program; of a function, between two pieces of its output; 0: any
  std::int64_t memory_bytes = 0;  ///< in addition to what it begins with; 0: any. Not with the address sanitizer
  double elapsed_s = 0.0;         ///< from its start until it has written all; 0: any
};

/// Where a program lies on PATH; nothing where it is not installed.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// Another process: a program, without a shell, or a function of this one. What it writes to its standard output is
/// read here, a piece at a time; its standard input is empty. It is ended with this object, and ends by itself at its
/// next output where this process was killed. It has no files open but those named here, and leaves no core file.
///
/// A function runs in a copy of this process (fork), which has none of its threads: a decoder of foreign files that on
/// a damaged one may never return, crash or take all memory does so there. A timer (ITIMER_PROF, whose signal ends the
/// child) limits its processor time, RLIMIT_DATA its memory. Children are started from any thread.
class ChildProcess {
 public:
  /// The descriptor under which the child finds the file that is handed over to it: /dev/fd/3.
  static constexpr int kHandedOver = 3;

  /// @param arguments   without the program's name
  /// @param file        that it is to read, or what it is for, for messages
  /// @param descriptor  open for reading, handed over; stays open here; -1: none
  /// @throws FileError where the system allows no more processes or files
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments, std::string file,
               int descriptor, const ChildLimits& limits);

  using Output = std::function<void(std::span<const std::byte>)>;
  /// What runs in the child; it must not use threads, nor wait for a lock that another thread may hold now. What it
  /// throws is thrown by finish().
  using Work = std::function<void(const Output& write)>;
  /// The other arguments as above.
  ChildProcess(const Work& work, std::string file, int descriptor, const ChildLimits& limits);

  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Ends the child at once.
  ~ChildProcess();

  /// Waits until all of `out` is filled or the child has closed its output. @return bytes read.
  /// @throws FileError, also where it takes longer than it may; Interrupted once a stop was requested
  std::size_t read(std::span<std::byte> out);

  /// After the end of its output: waits for the end of a program. @return whether it ended well (exit code 0)
  bool ended_well();
  /// How it ended, known after that: "exit code 3", "Segmentation fault".
  const std::string& end() const { return end_; }
  /// The first lines that a program wrote to standard error.
  const std::string& complaints() const { return complaints_; }
  /// Processor time that it and its own children took; known after its end.
  double processor_s() const { return processor_s_; }

  /// After the end of its output: waits for the end of a function.
  /// @param remedy  the end of the message where the child was ended: what to do with the file
  /// @throws FileError as the function threw it of the same file, or saying that the child crashed or exceeded a limit;
  ///         Interrupted where a stop was requested, or the child was ended by such a signal (Ctrl-C)
  void finish(const std::string& remedy);

 private:
  void start(const std::function<void()>& run, bool is_function, int descriptor);
  void take_complaints();
  void check_elapsed() const;
  int wait();

  std::string file_;
  ChildLimits limits_;
  pid_t child_ = -1;
  int output_ = -1, errors_ = -1;
  std::string complaints_, end_;
  std::chrono::steady_clock::time_point started_{};
  double processor_s_ = 0.0;
};

/// All that a program writes; it has not ended well where that is `most_bytes` or more. @throws FileError, Interrupted
struct ProgramResult {
  bool ended_well = false;
  std::string end;  ///< "exit code 3", "Segmentation fault", "more than 64 MB of output"
  std::string output, complaints;
  double processor_s = 0.0;
};
ProgramResult run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const std::string& file, int descriptor, const ChildLimits& limits,
                          std::size_t most_bytes = 1 << 16);

/// The first line of what a program complained of, without where in memory a part of it lies ("[aac @ 0x55d0]").
std::string first_complaint(const std::string& complaints);

}  // namespace bouncelab
