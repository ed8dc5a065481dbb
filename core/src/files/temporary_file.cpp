// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/descriptors.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
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

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}
Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

fs::path free_name(const fs::path& folder) {
  // not by std::random_device, which asks the processor what it is each time: in a virtual machine twice 8 us
  std::uint64_t number = 0;
  if (::getentropy(&number, sizeof number) != 0) number = static_cast<std::uint64_t>(std::clock());
  char name[40];
  std::snprintf(name, sizeof name, ".bouncelab-%016llx", static_cast<unsigned long long>(number));
  return folder / name;
}

TemporaryFile make_temporary_file(const fs::path& folder, mode_t mode) {
#ifdef O_TMPFILE
  if (Descriptor nameless(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, mode)); nameless.is_open())
    return {std::move(nameless), {}};
#endif
  for (;;) {
    const fs::path path = free_name(folder);
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode));
    if (file.is_open()) return {std::move(file), path};
    if (errno != EEXIST) throw std::system_error(errno, std::generic_category());
  }
}

Descriptor make_nameless_file(const fs::path& folder) {
  TemporaryFile file = make_temporary_file(folder, 0600);
  if (!file.path.empty()) ::unlink(file.path.c_str());
  return std::move(file.descriptor);
}

fs::path folder_for_temporary_files() {
  const char* named = std::getenv("TMPDIR");
  return named != nullptr && *named != '\0' ? fs::path(named) : fs::path("/tmp");
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

ScratchFile::ScratchFile(const std::filesystem::path& folder, std::string name) : state_(std::make_shared<State>()) {
  state_->name = std::move(name);
  try {
    state_->file = make_nameless_file(folder);
  } catch (const std::system_error& error) {
    throw FileError(state_->name,
                    "a temporary file in " + folder.string() + " cannot be made: " + error.code().message());
  }
}

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

/// A lock on an open file, against every other opening of it on this machine and, where the file system can, on others.
/// It ends with the descriptor, and so with the process, however that ends.
bool is_locked_by_another(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;  // else the file system has no locks
}

/// Whether an open file is still the one that has this name.
bool has_name(int descriptor, const fs::path& path) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

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

  ~State() { ::unlink(path.c_str()); }
};

FolderLock::FolderLock(const fs::path& folder) {
  const fs::path path = folder / ".bouncelab.lock";
  for (;;) {
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644));
    if (!file.is_open())
      throw FileError(folder.string(), "nothing can be written in this folder (" + std::string(std::strerror(errno)) +
                                           "); choose another one or check its permissions");
    if (is_locked_by_another(file.get()))
      throw FileError(folder.string(), "another bouncelab (process " + content_of(file.get()) +
                                           ") is at work in this folder; wait for it, or choose another folder");
    // the one that had it deletes the file before it lets go
    if (!has_name(file.get(), path)) continue;
    // of a run that was killed it stays, and whoever shares the folder must be able to take it
    if (::fchmod(file.get(), 0666) != 0) errno = 0;
    const std::string number = std::to_string(::getpid()) + "\n";
    if (::ftruncate(file.get(), 0) != 0 || write_all(file.get(), number.data(), number.size()) != 0)
      errno = 0;  // a full disk: only the number is missing in the message of the one that is refused
    state_.reset(new State{path, std::move(file)});
    return;
  }
}

}  // namespace bouncelab
