// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory_file.hpp"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "target.hpp"

namespace bouncelab::fuzz {

MemoryFile::MemoryFile(std::string_view content) : descriptor_(memfd_create("input", MFD_CLOEXEC)) {
  const bool written =
      descriptor_ >= 0 && pwrite(descriptor_, content.data(), content.size(), 0) == std::ssize(content);
  require(written, "there is memory for the input");
  path_ = "/proc/self/fd/" + std::to_string(descriptor_);
}

MemoryFile::~MemoryFile() { close(descriptor_); }

std::string MemoryFile::content() const {
  struct stat status {};
  fstat(descriptor_, &status);
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  const bool read = pread(descriptor_, bytes.data(), bytes.size(), 0) == std::ssize(bytes);
  require(read, "what was written can be read");
  return bytes;
}

}  // namespace bouncelab::fuzz
