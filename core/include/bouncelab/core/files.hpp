// SPDX-License-Identifier: GPL-3.0-or-later
/// Files: inputs that may be pipes, outputs that appear whole or not at all, and what is refused before work begins.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bouncelab {

/// An input's name in messages, tables and provenance: "standard input" for "-", else the path as it was given.
std::string input_name(const std::filesystem::path& path);

/// A path under which the content of an input can be opened as often as wanted, and read at any place. That is `path`
/// itself where it leads to a regular file. What can be read only once (a pipe, a FIFO, /dev/stdin, "-") is copied at
/// the first call for it to a temporary file without a name, in TMPDIR or /tmp, which lasts as long as the process.
/// Every reader opens its file by this; from any thread.
/// @throws FileError where there is no such file, it is a folder or a device without end, or cannot be read or copied;
///         Interrupted
std::filesystem::path readable(const std::filesystem::path& path);

/// Whether there is a file that the program may read although the user did not name it: beside an input, in a folder,
/// or named by an input. Such a file is read only if it is a regular file, or a link to one. A FIFO of that name would
/// be waited for, and a device may have no end.
bool is_unnamed_file(const std::filesystem::path& path);

/// The bytes of a file, or of memory, read at any place. A copy is of the same file.
class FileBytes {
 public:
  /// An input (readable()), open as long as a copy of this lives. @throws FileError where it cannot be read;
  /// Interrupted
  explicit FileBytes(const std::filesystem::path& path);
  /// @param descriptor  of a regular file open for reading; it stays the caller's
  FileBytes(int descriptor, std::string name);
  /// @param bytes  must outlive this
  FileBytes(std::span<const std::byte> bytes, std::string name);

  /// For messages.
  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }
  std::int64_t size() const { return size_; }
  /// @return how many bytes were read: fewer than asked for at the end of the file, and where it cannot be read
  std::int64_t read(std::int64_t first, std::span<std::byte> out);
  /// At most n bytes from `first` on.
  std::string text(std::int64_t first, std::size_t n);
  /// @throws FileError where reading failed, with the system's reason
  void check() const;

 private:
  std::string name_;
  std::shared_ptr<const void> opened_;  // closed with the last copy
  int descriptor_ = -1;
  std::span<const std::byte> memory_;
  std::int64_t size_ = 0;
  int error_ = 0;  // errno
};

/// A whole file as it is, for what is small. Streams of the standard library are no way to it: where memory is short
/// they end early and do not say so.
/// @throws FileError where it cannot be read; std::bad_alloc
std::string whole_content(const std::filesystem::path& path);

/// A file that appears whole or not at all: while it is written it has no name and is gone with its process, however
/// that ends; commit() gives it its name. On drives that have no such files (O_TMPFILE) it has a hidden name meanwhile,
/// which a process that is killed leaves behind.
///
/// Links are followed: the file behind them is replaced, with its permissions, and they stay. What is no file ("-" for
/// standard output, /dev/stdout, /dev/fd/N, /dev/null, a device, a FIFO) is never replaced: the file is written to
/// TMPDIR or /tmp, and commit() copies it.
class OutputFile {
 public:
  /// @throws FileExists where the file exists and may not be replaced; FileError where the folder does not exist or
  ///         cannot be written, or the name is too long
  OutputFile(std::filesystem::path path, bool may_replace);

  /// The file as it is until commit(), open for writing and reading.
  int descriptor() const;
  /// On whose drive it lies: its own, or of what goes to a stream the one for temporary files.
  const std::filesystem::path& folder() const;
  /// Behind what was written by this before. @throws FileError saying why not, Interrupted
  void write(std::string_view bytes);
  /// Puts the file in its place. @throws FileError; FileExists where another process made it meanwhile
  void commit();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Writes `content` whole or not at all. @throws FileError
void write_whole(const std::filesystem::path& path, std::string_view content, bool may_replace);

/// "the disk is full" and the like, from errno (0: not known); names the limits that people set themselves.
std::string why_writing_failed(int error);

/// Whether an output goes to what is no file: no other file can lie beside it.
bool is_stream(const std::filesystem::path& output);
/// Whether an output goes where standard output goes.
bool is_standard_output(const std::filesystem::path& output);

/// Writes text to standard output. @return 0, or errno: EPIPE where nobody reads it any more
int write_to_standard_output(std::string_view text);

/// To be called before any work with all files of it: what would destroy something, or come to nothing in the end, is
/// refused now. Empty paths are passed over.
///
/// No output may be an input or another output, by any name or link; it must be a file that may be replaced, a new name
/// in a folder that can be written, or a stream (see OutputFile). A stream can be read once only, and is read here (see
/// readable()).
/// @param inputs   files to be read; one that is missing is left to its reader
/// @param outputs  files to be written; several may go to /dev/null
/// @param beside   further outputs that are replaced where they exist (NAME.meta.json)
/// @throws InvalidArgument where two of them are the same file; FileExists, FileError as OutputFile and readable() do
void check_files(const std::vector<std::filesystem::path>& inputs, const std::vector<std::filesystem::path>& outputs,
                 const std::vector<std::filesystem::path>& beside, bool may_replace);

/// A file without a name, for what need not stay in memory; gone with this object, however the process ends.
class ScratchFile {
 public:
  /// @param folder  on whose file system it lies
  /// @param name    for people, of what it is needed for. @throws FileError
  ScratchFile(const std::filesystem::path& folder, std::string name);

  /// @return where it begins. @throws FileError (disk full)
  std::int64_t append(std::string_view bytes);
  /// What was appended there. @throws FileError
  std::string at(std::int64_t first, std::size_t n) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

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
