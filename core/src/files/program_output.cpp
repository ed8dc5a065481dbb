// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/program_output.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/interrupts.hpp"

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

/// What posix_spawn does in the new process before the program begins.
class SpawnSetup {
 public:
  SpawnSetup(int output, int errors, int handed_over, bool is_group) {
    posix_spawn_file_actions_init(&actions_);
    // a descriptor that has its number already would keep its close-on-exec: each goes by a number of its own
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, errors, STDERR_FILENO);
    if (handed_over >= 0) posix_spawn_file_actions_adddup2(&actions_, handed_over, ProgramOutput::kHandedOver);
    posix_spawnattr_init(&attributes_);
    sigset_t none, pipe;
    sigemptyset(&none);
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);  // which this process may ignore
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &pipe);
    posix_spawnattr_setpgroup(&attributes_, 0);
    const int group = is_group ? POSIX_SPAWN_SETPGROUP : 0;
    posix_spawnattr_setflags(&attributes_, static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | group));
  }
  SpawnSetup(const SpawnSetup&) = delete;
  SpawnSetup& operator=(const SpawnSetup&) = delete;
  ~SpawnSetup() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

/// A number above those that the new process gets.
int copy_above(int descriptor) { return descriptor < 0 ? -1 : ::fcntl(descriptor, F_DUPFD_CLOEXEC, 10); }

void limit_cpu(pid_t child, double seconds) {
  const auto whole = static_cast<rlim_t>(std::ceil(seconds));
  const rlimit limit{whole, whole + 1};
  // where a limit of the user's is lower, it stays
  ::prlimit(child, RLIMIT_CPU, &limit, nullptr);
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  std::istringstream folders(path == nullptr ? "/usr/local/bin:/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty() || folder.front() != '/') continue;  // what lies in a folder of recordings is not run
    std::filesystem::path program = std::filesystem::path(folder) / name;
    struct stat status {};
    if (::stat(program.c_str(), &status) == 0 && S_ISREG(status.st_mode) && ::access(program.c_str(), X_OK) == 0)
      return program;
  }
  return std::nullopt;
}

ProgramOutput::ProgramOutput(const std::filesystem::path& program, std::vector<std::string> arguments, std::string file,
                             int descriptor, double cpu_s, bool is_group)
    : file_(std::move(file)), is_group_(is_group) {
  Pipe output(file_), errors(file_);
  std::vector<char*> words;
  std::string name = program.filename().string();
  words.push_back(name.data());
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  const std::array<int, 3> above{copy_above(output.ends[1]), copy_above(errors.ends[1]), copy_above(descriptor)};
  const SpawnSetup setup(above[0], above[1], above[2], is_group);
  const int error = ::posix_spawn(&child_, program.c_str(), setup.actions(), setup.attributes(), words.data(), environ);
  for (const int copy : above)
    if (copy >= 0) ::close(copy);
  if (error != 0) {
    child_ = -1;
    throw FileError(file_, program.string() + " cannot be started (" + std::strerror(error) + ")");
  }
  if (cpu_s > 0.0) limit_cpu(child_, cpu_s);
  output_ = output.take_reading_end();
  errors_ = errors.take_reading_end();
  ::fcntl(errors_, F_SETFL, O_NONBLOCK);
}

ProgramOutput::~ProgramOutput() {
  if (output_ >= 0) ::close(output_);
  if (errors_ >= 0) ::close(errors_);
  if (child_ <= 0) return;
  ::kill(is_group_ ? -child_ : child_, is_group_ ? SIGTERM : SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void ProgramOutput::take_complaints() {
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

std::size_t ProgramOutput::read(std::span<std::byte> out) {
  std::size_t n = 0;
  while (n < out.size() && output_ >= 0) {
    throw_if_stop_requested();
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

bool ProgramOutput::ended_well() {
  while (errors_ >= 0) {
    throw_if_stop_requested();
    pollfd ready{errors_, POLLIN, 0};
    if (::poll(&ready, 1, kPiece_ms) > 0) take_complaints();
  }
  int status = 0;
  pid_t ended = -1;
  do ended = ::waitpid(child_, &status, 0);
  while (ended < 0 && errno == EINTR);
  child_ = -1;
  // Ctrl-C reaches it too
  throw_if_stop_requested();
  return ended > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

ProgramResult run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          const std::string& file, int descriptor, double cpu_s, std::size_t most_bytes) {
  ProgramOutput running(program, arguments, file, descriptor, cpu_s);
  ProgramResult result;
  result.output.resize(most_bytes);
  result.output.resize(running.read(std::as_writable_bytes(std::span(result.output))));
  if (result.output.size() < most_bytes) result.ended_well = running.ended_well();
  result.complaints = running.complaints();
  return result;
}

}  // namespace bouncelab
