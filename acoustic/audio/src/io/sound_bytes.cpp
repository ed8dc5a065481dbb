// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_bytes.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace bouncelab::audio {

SoundBytes::SoundBytes(int descriptor) : descriptor_(descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) == 0)
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
    const ssize_t got = pread(descriptor_, out.data() + n, out.size() - static_cast<std::size_t>(n), first + n);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error_ = errno;
    if (got <= 0) break;
    n += got;
  }
  return n;
}

}  // namespace bouncelab::audio
