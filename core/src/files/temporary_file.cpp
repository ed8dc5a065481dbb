// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/descriptors.hpp"

#include <fcntl.h>
#include <poll.h>
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

namespace {

/// A name in a folder that nobody has.
fs::path free_name(const fs::path& folder) {
  // not by std::random_device, which asks the processor what it is each time: in a virtual machine twice 8 us
  std::uint64_t number = 0;
  if (::getentropy(&number, sizeof number) != 0) number = static_cast<std::uint64_t>(std::clock());
  char name[40];
  std::snprintf(name, sizeof name, ".bouncelab-%016llx", static_cast<unsigned long long>(number));
  return folder / name;
}

}  // namespace

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
  std::string bytes = FileBytes(state_->file.get(), state_->name).text(first, n);
  if (bytes.size() < n)
    throw FileError(state_->name, "its temporary file cannot be read: " + std::string(std::strerror(errno)));
  return bytes;
}

}  // namespace bouncelab
