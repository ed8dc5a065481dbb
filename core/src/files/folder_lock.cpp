// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/folder_lock.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "bouncelab/core/error.hpp"
#include "files/temporary_file.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

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
    const std::string number = std::to_string(::getpid()) + "\n";
    if (::ftruncate(file.get(), 0) != 0 || write_all(file.get(), number.data(), number.size()) != 0)
      errno = 0;  // a full disk: only the number is missing in the message of the one that is refused
    state_ = std::make_unique<State>(State{path, std::move(file)});
    return;
  }
}

FolderLock::~FolderLock() { ::unlink(state_->path.c_str()); }

}  // namespace bouncelab
