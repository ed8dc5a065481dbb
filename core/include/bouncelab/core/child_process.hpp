// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

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

/// Whether a process that has other threads may start a child: not with the address sanitizer, whose allocator keeps
/// its locks over the fork, so that the child may wait for ever.
constexpr bool kMayStartChildBesideThreads = !kHasAddressSanitizer;

/// What a child process may use for one request.
struct ChildLimits {
  double cpu_s = 0.0;  ///< processor time; 0: what the request before has left of its own
  /// memory that it may take in addition to what it has; 0: as limited for the request before
  std::int64_t memory_bytes = 0;
};

/// A process that runs a reader of foreign files (libsndfile, HDF5), which on a damaged file may never return, crash or
/// take all memory. Each of these ends the child alone, and becomes a FileError of the file that was being read.
///
/// The child is a copy of this process (fork) and has none of its threads: it answers one request after the other, and
/// ends when this object goes, or when the process that owns it ends in any way, once it has answered. It limits its
/// own processor time by a timer (ITIMER_PROF, whose signal ends it) and its memory by RLIMIT_DATA; with the address
/// sanitizer memory is not limited. It has no files open but those that are handed over, and leaves no core file.
/// Threads may each have a child; one child is for one thread at a time.
class ChildProcess {
 public:
  /// Called in the child for each request.
  /// @param descriptor  of the file that came with the request, which the callee has to close; -1: none
  /// @return the answer. What it throws is thrown by ask
  using Answer = std::function<std::string(std::string_view request, int descriptor)>;

  /// @param answer   must not use threads, nor wait for a lock that another thread may hold now
  /// @param file     that is to be read, for messages
  /// @param prepare  called in the child before the first request comes; what it throws is for the request to find
  /// @throws FileError where the system allows no more processes
  ChildProcess(const Answer& answer, const std::string& file, const std::function<void()>& prepare = {});
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Ends the child at once.
  ~ChildProcess();

  /// @param file        that is being read, as messages name it
  /// @param remedy      the end of the message about a reader that was ended: what to do with the file
  /// @param descriptor  handed over to the child, and stays open here; -1: none
  /// @throws FileError as the child threw it of the same file, or saying that the child crashed or exceeded a limit;
  /// Interrupted once
  ///         a stop was requested, or where the child was ended by such a signal (Ctrl-C)
  std::string ask(std::string_view request, const ChildLimits& limits, const std::string& file,
                  const std::string& remedy, int descriptor = -1);

  /// ask() in two parts: what the caller does between them it does while the child is at work. Several requests may be
  /// begun, a few at a time, since they wait in the child's socket; their answers come in the same order.
  void begin(std::string_view request, const ChildLimits& limits, int descriptor = -1);
  /// The answer to the request begun first of those not finished yet.
  /// @param limits  for the message where they were exceeded
  /// @throws as ask(), which then is thrown by all that follow
  std::string finish(const ChildLimits& limits, const std::string& file, const std::string& remedy);

  /// False once a request failed: what a damaged file has left behind in the child's memory is not known. False as well
  /// while a request is not finished.
  bool is_usable() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Memory that this process and the children it starts later both see. Pages are taken when they are first written.
class SharedMemory {
 public:
  /// @throws std::bad_alloc
  explicit SharedMemory(std::size_t n_bytes);
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory();

  std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace bouncelab
