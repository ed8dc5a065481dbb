// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"

namespace bouncelab::audio {

ReadableFile::ReadableFile(const std::filesystem::path& path) : name_(input_name(path)) {
  const std::filesystem::path content = readable(path);
  std::error_code error;
  if (std::filesystem::file_size(content, error) == 0 && !error)
    throw FileError(name_, "the file is empty (0 bytes); record again");
  descriptor_ = ::open(content.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw FileError(name_,
                    std::string("cannot be opened for reading (") + std::strerror(errno) + "); check its permissions");
}

ReadableFile::~ReadableFile() { ::close(descriptor_); }

SoundBytes::SoundBytes(int descriptor) : descriptor_(descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) == 0)
    size_ = status.st_size;
  else
    error_ = errno;
}

SoundBytes::SoundBytes(std::span<const std::byte> bytes) : memory_(bytes), size_(std::ssize(bytes)) {}

std::int64_t SoundBytes::read(std::int64_t first, std::span<std::byte> out) {
  if (first < 0) return 0;
  if (descriptor_ < 0) {
    if (first >= size_) return 0;
    const std::int64_t n = std::min<std::int64_t>(std::ssize(out), size_ - first);
    std::copy_n(memory_.begin() + first, n, out.begin());
    return n;
  }
  std::int64_t n = 0;
  while (n < std::ssize(out)) {
    const ssize_t got = ::pread(descriptor_, out.data() + n, out.size() - static_cast<std::size_t>(n), first + n);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error_ = errno;
    if (got <= 0) break;
    n += got;
  }
  return n;
}

std::string SoundBytes::text(std::int64_t first, std::size_t n) {
  std::string text(n, '\0');
  text.resize(static_cast<std::size_t>(read(first, std::as_writable_bytes(std::span(text)))));
  return text;
}

void SoundBytes::check(const std::string& name) const {
  if (error_ != 0)
    throw FileError(name, std::string("cannot be read (") + std::strerror(error_) + "); copy it to a local disk");
}

}  // namespace bouncelab::audio
