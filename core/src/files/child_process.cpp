// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/interrupts.hpp"

namespace bouncelab {
namespace {

struct RequestHead {
  std::uint64_t n_bytes = 0;
  ChildLimits limits{};
  bool has_descriptor = false;
};

enum class Ending : std::int32_t { answered, file_error, no_memory, other_error };

struct AnswerHead {
  std::uint64_t n_bytes = 0;
  Ending ending = Ending::answered;
};

// ---- messages over the socket: false where the other side has ended

bool send_all(int socket, const void* data, std::size_t n) {
  const char* at = static_cast<const char*>(data);
  while (n > 0) {
    const ssize_t sent = send(socket, at, n, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    n -= static_cast<std::size_t>(sent);
  }
  return true;
}

/// At once, as the other side would wake up for each part.
template <class Head>
bool send_message(int socket, const Head& head, std::string_view text) {
  std::array<iovec, 2> parts{iovec{const_cast<Head*>(&head), sizeof head},
                             iovec{const_cast<char*>(text.data()), text.size()}};
  msghdr message{};
  message.msg_iov = parts.data();
  message.msg_iovlen = parts.size();
  ssize_t sent = -1;
  do sent = sendmsg(socket, &message, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  if (sent < 0) return false;
  const std::size_t n_of_head = std::min(static_cast<std::size_t>(sent), sizeof head);
  const std::size_t n_of_text = static_cast<std::size_t>(sent) - n_of_head;
  return send_all(socket, reinterpret_cast<const char*>(&head) + n_of_head, sizeof head - n_of_head) &&
         send_all(socket, text.data() + n_of_text, text.size() - n_of_text);
}

bool receive_all(int socket, void* data, std::size_t n) {
  char* at = static_cast<char*>(data);
  while (n > 0) {
    const ssize_t got = recv(socket, at, n, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    n -= static_cast<std::size_t>(got);
  }
  return true;
}

/// One byte with a file: a descriptor of the same file is open on the other side then (unix(7), SCM_RIGHTS).
struct DescriptorMessage {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  char byte = 0;
  iovec part{&byte, 1};
  msghdr message{};

  DescriptorMessage() {
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
  }
};

bool send_descriptor(int socket, int descriptor) {
  DescriptorMessage m;
  cmsghdr* head = CMSG_FIRSTHDR(&m.message);
  head->cmsg_level = SOL_SOCKET;
  head->cmsg_type = SCM_RIGHTS;
  head->cmsg_len = CMSG_LEN(sizeof descriptor);
  std::memcpy(CMSG_DATA(head), &descriptor, sizeof descriptor);
  ssize_t sent = -1;
  do sent = sendmsg(socket, &m.message, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent == 1;
}

/// @return -1 where there was none
int receive_descriptor(int socket) {
  DescriptorMessage m;
  ssize_t got = -1;
  do got = recvmsg(socket, &m.message, MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  const cmsghdr* head = got == 1 ? CMSG_FIRSTHDR(&m.message) : nullptr;
  if (head == nullptr || head->cmsg_type != SCM_RIGHTS) return -1;
  int descriptor = -1;
  std::memcpy(&descriptor, CMSG_DATA(head), sizeof descriptor);
  return descriptor;
}

// ---- in the child

constexpr int kSocket = 3;

/// Signals end the child as if it were a program of its own, and of the files open here it keeps its socket only: one
/// that holds the socket of another child would keep it from noticing that its owner has ended.
void detach(int socket) {
  // the files first: where the owner is killed now, their locks must not outlive it
  if (socket != kSocket) dup2(socket, kSocket);
  if (close_range(kSocket + 1, ~0U, 0) != 0)  // Linux before 5.9
    for (int descriptor = kSocket + 1; descriptor < 4096; ++descriptor) close(descriptor);
  for (int signal = 1; signal < NSIG; ++signal) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = open("/dev/null", O_RDWR);
  // a reader that is ended says so on standard error, beside our own message; a sanitizer's report is wanted
  for (int descriptor = 0; descriptor < (kHasAddressSanitizer ? 2 : 3); ++descriptor) dup2(nothing, descriptor);
  if (nothing > kSocket) close(nothing);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
}

/// Private memory that can be written to, which is what RLIMIT_DATA limits; 0 where the system does not tell.
std::uint64_t data_bytes() {
  std::array<char, 256> text{};
  const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t n = read(file, text.data(), text.size() - 1);
  close(file);
  unsigned long long pages = 0;  // the sixth number
  if (n <= 0 || std::sscanf(text.data(), "%*u %*u %*u %*u %*u %llu", &pages) != 1) return 0;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit_memory(std::int64_t more_bytes) {
  const std::uint64_t now = data_bytes();
  rlimit limit{};
  if (kHasAddressSanitizer || now == 0 || getrlimit(RLIMIT_DATA, &limit) != 0) return;
  const std::uint64_t wanted = now + static_cast<std::uint64_t>(more_bytes);
  if (limit.rlim_max != RLIM_INFINITY && wanted > limit.rlim_max) return;  // the user's limit is lower
  limit.rlim_cur = wanted;
  setrlimit(RLIMIT_DATA, &limit);
}

/// SIGPROF ends the child when it has used so much processor time from now on.
void limit_cpu(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - std::floor(seconds)));
  setitimer(ITIMER_PROF, &timer, nullptr);
}

/// The answer, or what was thrown.
std::pair<Ending, std::string> answer_to(const ChildProcess::Answer& answer, std::string_view request, int descriptor) {
  try {
    return {Ending::answered, answer(request, descriptor)};
  } catch (const FileError& error) {
    return {Ending::file_error, error.what()};
  } catch (const std::bad_alloc&) {
    return {Ending::no_memory, ""};
  } catch (const std::length_error&) {
    return {Ending::no_memory, ""};
  } catch (const std::exception& error) {
    return {Ending::other_error, error.what()};
  }
}

void prepare_to_serve(const std::function<void()>& prepare) {
  try {
    if (prepare) prepare();
  } catch (const std::exception&) {  // of the request that will need it
  }
}

/// Until the owner has closed its side or ended.
void serve(const ChildProcess::Answer& answer) {
  for (RequestHead head; receive_all(kSocket, &head, sizeof head);) {
    std::string request(head.n_bytes, '\0');
    if (!receive_all(kSocket, request.data(), request.size())) return;
    const int descriptor = head.has_descriptor ? receive_descriptor(kSocket) : -1;
    if (head.limits.memory_bytes > 0) limit_memory(head.limits.memory_bytes);
    if (head.limits.cpu_s > 0.0) limit_cpu(head.limits.cpu_s);  // which waiting for the next request does not use
    const auto [ending, text] = answer_to(answer, request, descriptor);
    const AnswerHead answered{text.size(), ending};
    if (!send_message(kSocket, answered, text)) return;
  }
}

/// In pieces, so that a request to stop is seen. @throws Interrupted
void wait_for_answer(int socket) {
  constexpr int kPiece_ms = 100;
  pollfd answer{socket, POLLIN, 0};
  while (poll(&answer, 1, kPiece_ms) <= 0) throw_if_stop_requested();
}

std::string amount(double value, const char* unit) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.0f %s", value, unit);
  return text.data();
}

std::string too_much_memory(const ChildLimits& limits, const std::string& remedy) {
  return "takes more than " + amount(static_cast<double>(limits.memory_bytes) / 1e6, "MB") +
         " of memory to read: damaged? " + remedy;
}

/// The message of a FileError of the file, which is to be thrown again.
std::string without_name(const std::string& message, const std::string& file) {
  const std::string name = FileError(file, "").what();
  return message.rfind(name, 0) == 0 ? message.substr(name.size()) : message;
}

[[noreturn]] void throw_end_of(pid_t& of, const ChildLimits& limits, const std::string& file,
                               const std::string& remedy) {
  int status = 0;
  pid_t ended = -1;
  do ended = waitpid(of, &status, 0);
  while (ended < 0 && errno == EINTR);
  const pid_t child = std::exchange(of, 0);
  if (ended != child || !WIFSIGNALED(status))  // the host program may have waited for it
    throw FileError(file, "ended the process that read it: damaged? " + remedy);
  const int signal = WTERMSIG(status);
  if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP) throw Interrupted();
  if (signal == SIGPROF)
    throw FileError(file,
                    "takes more than " + amount(limits.cpu_s, "s") + " of processor time to read: damaged? " + remedy);
  throw FileError(file, std::string("ended the process that read it (") + strsignal(signal) + "): damaged? " + remedy);
}

}  // namespace

struct ChildProcess::State {
  pid_t owner = getpid(), child = 0;
  int socket = -1;
  bool has_failed = false;
  std::size_t n_begun = 0;  // requests whose answers have not come

  bool is_owned() const { return getpid() == owner; }
};

ChildProcess::ChildProcess(const Answer& answer, const std::string& file, const std::function<void()>& prepare)
    : state_(std::make_unique<State>()) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw FileError(file, std::string("no process can be started to read files (") + std::strerror(errno) +
                              "); are too many files open?");
  state_->child = fork();
  if (state_->child == 0) {
    try {
      detach(ends[1]);
      prepare_to_serve(prepare);
      serve(answer);
    } catch (...) {  // no memory for a request
    }
    _exit(0);  // not exit: what the owner's buffers hold is written by the owner
  }
  const int error = errno;
  close(ends[1]);
  if (state_->child > 0) {
    state_->socket = ends[0];
    return;
  }
  close(ends[0]);
  throw FileError(file, std::string("no process can be started to read files (") + std::strerror(error) +
                            "); end other programs, or allow more processes (ulimit -u)");
}

ChildProcess::~ChildProcess() {
  const State& s = *state_;
  close(s.socket);
  if (s.child <= 0 || getpid() != s.owner) return;  // of a copy of the owner
  kill(s.child, SIGKILL);
  while (waitpid(s.child, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool ChildProcess::is_usable() const { return !state_->has_failed && state_->n_begun == 0 && state_->is_owned(); }

std::string ChildProcess::ask(std::string_view request, const ChildLimits& limits, const std::string& file,
                              const std::string& remedy, int descriptor) {
  begin(request, limits, descriptor);
  return finish(limits, file, remedy);
}

void ChildProcess::begin(std::string_view request, const ChildLimits& limits, int descriptor) {
  State& s = *state_;
  ++s.n_begun;
  if (s.has_failed || !s.is_owned()) return;  // finish() says so
  const RequestHead head{request.size(), limits, descriptor >= 0};
  // where the child has ended, its answer will be missing
  static_cast<void>(send_message(s.socket, head, request) && (descriptor < 0 || send_descriptor(s.socket, descriptor)));
}

std::string ChildProcess::finish(const ChildLimits& limits, const std::string& file, const std::string& remedy) {
  State& s = *state_;
  const bool has_failed = std::exchange(s.has_failed, true);  // until all has gone well
  if (has_failed || s.n_begun == 0 || !s.is_owned()) throw FileError(file, "cannot be read: its reader has ended");
  --s.n_begun;
  AnswerHead answered;
  std::string text;
  wait_for_answer(s.socket);
  bool is_alive = receive_all(s.socket, &answered, sizeof answered);
  if (is_alive) {
    text.resize(answered.n_bytes);
    is_alive = receive_all(s.socket, text.data(), text.size());
  }
  if (!is_alive) throw_end_of(s.child, limits, file, remedy);
  switch (answered.ending) {
    case Ending::answered:
      break;
    case Ending::file_error:
      throw FileError(file, without_name(text, file));
    case Ending::no_memory:
      throw FileError(file, too_much_memory(limits, remedy));
    case Ending::other_error:
      throw FileError(file, "cannot be read (" + text + "): damaged? " + remedy);
  }
  s.has_failed = false;
  return text;
}

SharedMemory::SharedMemory(std::size_t n_bytes) {
  void* memory = mmap(nullptr, n_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  bytes_ = {static_cast<std::byte*>(memory), n_bytes};
}

SharedMemory::~SharedMemory() { munmap(bytes_.data(), bytes_.size()); }

}  // namespace bouncelab
