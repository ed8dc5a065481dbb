// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kMostComplaints_bytes = 4096;  // a damaged file may give a line for each of its frames
constexpr int kPiece_ms = 100;                       // after which a request to stop is seen

/// The two ends of a pipe, closed with this; no other program that is started meanwhile inherits them.
struct Pipe {
  std::array<int, 2> ends{-1, -1};
  explicit Pipe(const std::string& file) {
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
      throw FileError(file,
                      std::string("no pipe can be made (") + std::strerror(errno) + "); are too many files open?");
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    for (const int end : ends)
      if (end >= 0) ::close(end);
  }
  int take_reading_end() { return std::exchange(ends[0], -1); }
};

// ---- in the child

constexpr int kComplaints = 4;  // of a function: what libraries write to standard error is not wanted

enum ExitCode : char { kWell = 0, kThrewFileError = 3, kHadNoMemory = 4, kThrewOther = 5, kNotStarted = 127 };

/// Signals end the child as if nobody had asked for them here; what the user ignores (nohup) it ignores too.
void forget_signal_handlers() {
  for (int signal = 1; signal < NSIG; ++signal) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) != 0 || (action.sa_handler == SIG_IGN && signal != SIGPIPE)) continue;
    action = {};
    action.sa_handler = SIG_DFL;
    ::sigaction(signal, &action, nullptr);
  }
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// Of all files open here the child keeps those that it needs: one that held a pipe of another child would keep it from
/// ending, and where this process is killed now, the locks of its files must not outlive it.
void arrange_files(int output, int errors, int handed_over, bool is_function) {
  const auto above = [](int descriptor) { return descriptor < 0 ? -1 : ::fcntl(descriptor, F_DUPFD_CLOEXEC, 10); };
  output = above(output);
  errors = above(errors);
  handed_over = above(handed_over);
  const int nothing = above(::open("/dev/null", O_RDWR));
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  // a library that is ended says so on standard error, beside our own message; a sanitizer's report is wanted
  if (!is_function)
    ::dup2(errors, STDERR_FILENO);
  else if (!kHasAddressSanitizer)
    ::dup2(nothing, STDERR_FILENO);
  ::close(ChildProcess::kHandedOver);
  if (handed_over >= 0) ::dup2(handed_over, ChildProcess::kHandedOver);
  if (is_function) ::dup2(errors, kComplaints);
  const int first_unused = is_function ? kComplaints + 1 : kComplaints;
  if (::close_range(static_cast<unsigned>(first_unused), ~0U, 0) != 0)  // Linux before 5.9
    for (int descriptor = first_unused; descriptor < 4096; ++descriptor) ::close(descriptor);
}

/// Private memory that can be written to, which is what RLIMIT_DATA limits; 0 where the system does not tell.
std::uint64_t data_bytes() {
  std::array<char, 256> text{};
  const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t n = ::read(file, text.data(), text.size() - 1);
  ::close(file);
  unsigned long long pages = 0;  // the sixth number
  if (n <= 0 || std::sscanf(text.data(), "%*u %*u %*u %*u %*u %llu", &pages) != 1) return 0;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit_memory(std::int64_t more_bytes) {
  const std::uint64_t now = more_bytes > 0 ? data_bytes() : 0;
  rlimit limit{};
  if (kHasAddressSanitizer || now == 0 || ::getrlimit(RLIMIT_DATA, &limit) != 0) return;
  const std::uint64_t wanted = now + static_cast<std::uint64_t>(more_bytes);
  if (limit.rlim_max != RLIM_INFINITY && wanted > limit.rlim_max) return;  // the user's limit is lower
  limit.rlim_cur = wanted;
  ::setrlimit(RLIMIT_DATA, &limit);
}

/// SIGPROF ends the process when it has used so much processor time from now on, also another program in its place.
void limit_cpu(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - std::floor(seconds)));
  if (seconds > 0.0) ::setitimer(ITIMER_PROF, &timer, nullptr);
}

void write_to(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) ::_exit(kNotStarted);  // nobody reads it any more
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

/// The code is written too: where the host program waits for all its children, none is left for waitpid here.
[[noreturn]] void end_with(ExitCode exit_code, std::string_view complaint = {}) {
  const std::string message = static_cast<char>(exit_code) + std::string(complaint.substr(0, 1000));
  write_to(kComplaints, std::as_bytes(std::span(message)));
  ::_exit(exit_code);  // not exit: what this process has in its buffers is its own to write
}

[[noreturn]] void run_work(const ChildProcess::Work& work, const ChildLimits& limits) {
  try {
    work([&](std::span<const std::byte> bytes) {
      write_to(STDOUT_FILENO, bytes);
      limit_cpu(limits.cpu_s);
    });
  } catch (const FileError& error) {
    end_with(kThrewFileError, error.what());
  } catch (const std::bad_alloc&) {
    end_with(kHadNoMemory);
  } catch (const std::length_error&) {
    end_with(kHadNoMemory);
  } catch (const std::exception& error) {
    end_with(kThrewOther, error.what());
  }
  end_with(kWell);
}

// ---- messages

/// The message of a FileError of the file, which is to be thrown again.
std::string without_name(const std::string& message, const std::string& file) {
  const std::string name = FileError(file, "").what();
  return message.rfind(name, 0) == 0 ? message.substr(name.size()) : message;
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  std::istringstream folders(path == nullptr ? "/usr/local/bin:/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty() || folder.front() != '/') continue;  // what lies in a folder of recordings is not run
    std::filesystem::path program = std::filesystem::path(folder) / name;
    struct stat status {};
    if (::access(program.c_str(), X_OK) == 0 && ::stat(program.c_str(), &status) == 0 && S_ISREG(status.st_mode))
      return program;
  }
  return std::nullopt;
}

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           std::string file, int descriptor, const ChildLimits& limits)
    : file_(std::move(file)), limits_(limits) {
  std::string name = program.string(), complaint = name + " cannot be started\n";
  std::vector<std::string> copies = arguments;
  std::vector<char*> words{name.data()};
  for (std::string& argument : copies) words.push_back(argument.data());
  words.push_back(nullptr);
  start(
      [&] {
        ::execv(name.c_str(), words.data());
        write_to(STDERR_FILENO, std::as_bytes(std::span(complaint)));
        ::_exit(kNotStarted);
      },
      false, descriptor);
}

ChildProcess::ChildProcess(const Work& work, std::string file, int descriptor, const ChildLimits& limits)
    : file_(std::move(file)), limits_(limits) {
  start([&] { run_work(work, limits); }, true, descriptor);
}

void ChildProcess::start(const std::function<void()>& run, bool is_function, int descriptor) {
  Pipe output(file_), errors(file_);
  started_ = std::chrono::steady_clock::now();
  child_ = ::fork();
  if (child_ < 0)
    throw FileError(file_, std::string("no process can be started to read files (") + std::strerror(errno) +
                               "); end other programs, or allow more processes (ulimit -u)");
  if (child_ == 0) {
    arrange_files(output.ends[1], errors.ends[1], descriptor, is_function);
    forget_signal_handlers();
    if (limits_.elapsed_s > 0.0) ::setpgid(0, 0);  // what it starts is ended with it
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    limit_memory(limits_.memory_bytes);
    limit_cpu(limits_.cpu_s);
    run();
  }
  if (limits_.elapsed_s > 0.0) ::setpgid(child_, child_);  // here too: which of the two comes first is not known
  output_ = output.take_reading_end();
  errors_ = errors.take_reading_end();
  ::fcntl(errors_, F_SETFL, O_NONBLOCK);
}

ChildProcess::~ChildProcess() {
  if (output_ >= 0) ::close(output_);
  if (errors_ >= 0) ::close(errors_);
  if (child_ <= 0) return;
  ::kill(limits_.elapsed_s > 0.0 ? -child_ : child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void ChildProcess::take_complaints() {
  std::array<char, 4096> text{};
  for (;;) {
    const ssize_t n = ::read(errors_, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) ::close(std::exchange(errors_, -1));
    if (n <= 0) return;
    const std::size_t room = kMostComplaints_bytes - std::min(complaints_.size(), kMostComplaints_bytes);
    complaints_.append(text.data(), std::min(room, static_cast<std::size_t>(n)));
  }
}

/// The child itself ends with this object.
void ChildProcess::check_elapsed() const {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started_;
  if (limits_.elapsed_s > 0.0 && elapsed.count() > limits_.elapsed_s)
    throw FileError(file_, "the program was ended after " + formatted("%.0f s", limits_.elapsed_s));
}

std::size_t ChildProcess::read(std::span<std::byte> out) {
  std::size_t n = 0;
  while (n < out.size() && output_ >= 0) {
    throw_if_stop_requested();
    check_elapsed();
    std::array<pollfd, 2> ready{{{output_, POLLIN, 0}, {errors_, POLLIN, 0}}};  // -1 is passed over
    if (::poll(ready.data(), ready.size(), kPiece_ms) <= 0) continue;
    if (ready[1].revents != 0) take_complaints();
    if (ready[0].revents == 0) continue;
    const ssize_t got = ::read(output_, out.data() + n, out.size() - n);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got < 0) throw FileError(file_, std::string("what it writes cannot be read (") + std::strerror(errno) + ")");
    if (got == 0) ::close(std::exchange(output_, -1));
    n += static_cast<std::size_t>(got);
  }
  return n;
}

/// @return the status of waitpid, -1 where somebody else has waited for the child
int ChildProcess::wait() {
  if (output_ >= 0) ::close(std::exchange(output_, -1));  // which ends a child that goes on writing
  while (errors_ >= 0) {
    throw_if_stop_requested();
    check_elapsed();
    pollfd ready{errors_, POLLIN, 0};
    if (::poll(&ready, 1, kPiece_ms) > 0) take_complaints();
  }
  int status = 0;
  pid_t ended = -1;
  rusage used{};
  do ended = ::wait4(child_, &status, 0, &used);
  while (ended < 0 && errno == EINTR);
  child_ = -1;
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  processor_s_ = seconds(used.ru_utime) + seconds(used.ru_stime);
  throw_if_stop_requested();  // Ctrl-C reaches the child too
  return ended > 0 ? status : -1;
}

bool ChildProcess::ended_well() {
  const int status = wait();
  if (status != -1 && WIFSIGNALED(status)) end_ = ::strsignal(WTERMSIG(status));
  if (status != -1 && WIFEXITED(status)) end_ = "exit code " + std::to_string(WEXITSTATUS(status));
  return status != -1 && WIFEXITED(status) && WEXITSTATUS(status) == kWell;
}

void ChildProcess::finish(const std::string& remedy) {
  const int status = wait();
  const auto refuse = [&](const std::string& what) { throw FileError(file_, what + ": damaged? " + remedy); };
  const bool has_returned = !complaints_.empty();
  const std::string complaint = has_returned ? complaints_.substr(1) : "";
  if (!has_returned && status != -1 && WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP) throw Interrupted();
    if (signal == SIGPROF)
      refuse("takes more than " + formatted("%.0f s", limits_.cpu_s) + " of processor time to read");
    refuse(std::string("ended the process that read it (") + ::strsignal(signal) + ")");
  }
  switch (has_returned ? static_cast<ExitCode>(complaints_.front()) : kNotStarted) {
    case kWell:
      return;
    case kThrewFileError:
      throw FileError(file_, without_name(complaint, file_));
    case kHadNoMemory:
      refuse("takes more than " + formatted("%.0f MB", static_cast<double>(limits_.memory_bytes) / 1e6) +
             " of memory to read");
      break;
    case kThrewOther:
      refuse("cannot be read (" + complaint + ")");
      break;
    default:
      refuse("ended the process that read it");
  }
}

ProgramResult run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const std::string& file, int descriptor, const ChildLimits& limits, std::size_t most_bytes) {
  ChildProcess running(program, arguments, file, descriptor, limits);
  ProgramResult result;
  result.output.resize(most_bytes);
  result.output.resize(running.read(std::as_writable_bytes(std::span(result.output))));
  if (result.output.size() < most_bytes) {
    result.ended_well = running.ended_well();
    result.end = running.end();
  } else {
    result.end = "more than " + formatted("%.0f MB", static_cast<double>(most_bytes) / 1e6) + " of output";
  }
  result.complaints = running.complaints();
  result.processor_s = running.processor_s();
  return result;
}

std::string first_complaint(const std::string& complaints) {
  std::string line = complaints.substr(0, complaints.find('\n'));
  if (const std::size_t at = line.find(" @ 0x"); at != std::string::npos)
    line.erase(at, std::min(line.find(']', at), line.size()) - at);
  return line.empty() ? "no reason given" : line;
}

}  // namespace bouncelab
