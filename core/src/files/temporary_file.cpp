// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/temporary_file.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPrefix = ".bouncelab-";
constexpr std::string_view kInfix = ".partial";
constexpr std::size_t kLongestExtension = 16;  // longer ones are no format's, and names end at 255 bytes

std::string hexadecimal(std::uint64_t number) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%08llx", static_cast<unsigned long long>(number & 0xFFFFFFFFu));
  return digits;
}

/// Tells this machine's files from those of others on a network drive, whose locks may not be seen here.
const std::string& machine() {
  static const std::string name = [] {
    char host[HOST_NAME_MAX + 1] = "";
    ::gethostname(host, sizeof host - 1);
    std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
    for (const char* c = host; *c != '\0'; ++c) hash = (hash ^ static_cast<unsigned char>(*c)) * 0x100000001b3u;
    return hexadecimal(hash ^ hash >> 32);
  }();
  return name;
}

/// std::random_device asks the processor what it is each time, which in a virtual machine takes twice 8 us.
std::uint64_t random_number() {
  std::uint64_t number = 0;
  // where the system has none the name is the process's: one that exists is not taken
  if (::getentropy(&number, sizeof number) != 0) number = static_cast<std::uint64_t>(std::clock());
  return number;
}

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

/// Whether the process that a temporary file is named after has ended.
bool has_ended(const std::string& name, std::size_t pid_at) {
  const long pid = std::strtol(name.c_str() + pid_at, nullptr, 10);
  return pid > 0 && ::kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH;
}

/// A process that was killed while it started a child leaves its locks to the child, until that gets a processor for
/// the first time and closes what it does not need: then they are waited for.
LockResult lock_left_by(int descriptor, bool owner_has_ended) {
  constexpr int kTries = 40;
  constexpr useconds_t kBetween_us = 5'000;
  LockResult lock = lock_exclusively(descriptor);
  for (int k = 0; k < kTries && owner_has_ended && lock == LockResult::held_by_another; ++k) {
    ::usleep(kBetween_us);
    lock = lock_exclusively(descriptor);
  }
  return lock;
}

void remove_if_abandoned(const fs::path& path, bool owner_has_ended) {
  const Descriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  if (lock_left_by(file.get(), owner_has_ended) != LockResult::taken || !has_name(file.get(), path)) return;
  ::unlink(path.c_str());
}

}  // namespace

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}
Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

LockResult lock_exclusively(int descriptor) {
#ifdef F_OFD_SETLK
  // of the opening, not of the process: it also excludes other threads
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  const int status = ::fcntl(descriptor, F_OFD_SETLK, &lock);
#else
  const int status = ::flock(descriptor, LOCK_EX | LOCK_NB);
#endif
  if (status == 0) return LockResult::taken;
  return errno == EAGAIN || errno == EACCES ? LockResult::held_by_another : LockResult::not_supported;
}

bool has_name(int descriptor, const fs::path& path) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

TemporaryFile make_temporary_file(const fs::path& folder, const std::string& extension, mode_t mode) {
  const std::string ending = extension.size() <= kLongestExtension ? extension : std::string();
  for (;;) {
    const fs::path path = folder / (std::string(kPrefix) + machine() + "-" + std::to_string(::getpid()) + "-" +
                                    hexadecimal(random_number()) + std::string(kInfix) + ending);
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode));
    if (!file.is_open()) {
      if (errno == EEXIST) continue;
      fail(errno);
    }
    // another process that tidies up may have had it between its creation and its lock
    if (lock_exclusively(file.get()) == LockResult::held_by_another || !has_name(file.get(), path)) continue;
    return {path, std::move(file)};
  }
}

Descriptor make_nameless_file(const fs::path& folder) {
#ifdef O_TMPFILE
  Descriptor nameless(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  if (nameless.is_open()) return nameless;
#endif
  // network drives and some file systems cannot do that
  TemporaryFile named = make_temporary_file(folder, "", 0600);
  ::unlink(named.path.c_str());
  return std::move(named.descriptor);
}

fs::path folder_for_temporary_files() {
  const char* named = std::getenv("TMPDIR");
  return named != nullptr && *named != '\0' ? fs::path(named) : fs::path("/tmp");
}

void remove_abandoned_files(const fs::path& folder) {
  const std::string ours = std::string(kPrefix) + machine() + "-";
  // not by fs::directory_iterator, which ends the process where it gets no memory
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(folder.c_str()), &::closedir);
  while (const dirent* entry = entries ? ::readdir(entries.get()) : nullptr) {
    const std::string name = entry->d_name;
    if (name.starts_with(ours) && name.find(kInfix, ours.size()) != std::string::npos)
      remove_if_abandoned(folder / name, has_ended(name, ours.size()));
  }
}

int write_all(int descriptor, const char* bytes, std::size_t n) {
  // a pipe that can be written to takes so much without making the writer wait, who would not see a signal meanwhile
  struct stat status {};
  const bool is_file = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const std::size_t at_once = is_file ? n : PIPE_BUF;
  while (n > 0) {
    if (!is_file) {
      pollfd ready{descriptor, POLLOUT, 0};
      if (::poll(&ready, 1, 100) <= 0) {
        throw_if_stop_requested();
        continue;
      }
    }
    const ssize_t written = ::write(descriptor, bytes, std::min(n, at_once));
    if (written < 0 && (errno == EINTR || errno == EAGAIN)) {
      throw_if_stop_requested();
      continue;
    }
    if (written < 0) return errno;
    bytes += written;
    n -= static_cast<std::size_t>(written);
  }
  return 0;
}

// ---- what need not stay in memory

struct ScratchFile::State {
  std::string name;
  Descriptor file;
  std::int64_t size = 0;
};

ScratchFile::ScratchFile(const std::filesystem::path& folder, std::string name) : state_(std::make_unique<State>()) {
  state_->name = std::move(name);
  try {
    state_->file = make_nameless_file(folder);
  } catch (const std::system_error& error) {
    throw FileError(state_->name,
                    "a temporary file in " + folder.string() + " cannot be made: " + error.code().message());
  }
}

ScratchFile::ScratchFile(ScratchFile&&) noexcept = default;
ScratchFile& ScratchFile::operator=(ScratchFile&&) noexcept = default;
ScratchFile::~ScratchFile() = default;

std::int64_t ScratchFile::append(std::string_view bytes) {
  if (const int error = write_all(state_->file.get(), bytes.data(), bytes.size()); error != 0)
    throw FileError(state_->name, why_writing_failed(error));
  return std::exchange(state_->size, state_->size + std::ssize(bytes));
}

std::string ScratchFile::at(std::int64_t first, std::size_t n) const {
  std::string bytes(n, '\0');
  for (std::size_t done = 0; done < n;) {
    const ssize_t got =
        ::pread(state_->file.get(), bytes.data() + done, n - done, first + static_cast<std::int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw FileError(state_->name, "its temporary file cannot be read: " + std::string(std::strerror(errno)));
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

// ---- one run at a time in a folder

namespace {

std::string content_of(int descriptor) {
  char text[32];
  const ssize_t n = ::pread(descriptor, text, sizeof text, 0);
  std::string content(text, n > 0 ? static_cast<std::size_t>(n) : 0);
  return content.substr(0, content.find('\n'));
}

}  // namespace

struct FolderLock::State {
  fs::path path;
  Descriptor file;
};

FolderLock::FolderLock(const fs::path& folder) {
  const fs::path path = folder / ".bouncelab.lock";
  for (;;) {
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644));
    if (!file.is_open())
      throw FileError(folder.string(), "nothing can be written in this folder (" + std::string(std::strerror(errno)) +
                                           "); choose another one or check its permissions");
    if (lock_exclusively(file.get()) == LockResult::held_by_another)
      throw FileError(folder.string(), "another bouncelab (process " + content_of(file.get()) +
                                           ") is at work in this folder; wait for it, or choose another folder");
    // the one that had it deletes the file before it lets go
    if (!has_name(file.get(), path)) continue;
    // of a run that was killed it stays, and whoever shares the folder must be able to take it
    if (::fchmod(file.get(), 0666) != 0) errno = 0;
    const std::string number = std::to_string(::getpid()) + "\n";
    if (::ftruncate(file.get(), 0) != 0 || write_all(file.get(), number.data(), number.size()) != 0)
      errno = 0;  // a full disk: only the number is missing in the message of the one that is refused
    state_ = std::make_unique<State>(State{path, std::move(file)});
    return;
  }
}

FolderLock::~FolderLock() { ::unlink(state_->path.c_str()); }

}  // namespace bouncelab
