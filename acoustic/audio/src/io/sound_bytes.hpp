// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace bouncelab::audio {

/// The bytes of a sound file, on disk or in memory, read at any place.
class SoundBytes {
 public:
  /// @param descriptor  of a regular file open for reading; it stays the caller's
  explicit SoundBytes(int descriptor);
  /// @param bytes  must outlive this
  explicit SoundBytes(std::span<const std::byte> bytes);

  std::int64_t size() const { return size_; }
  /// @return how many bytes were read: fewer than asked for at the end of the file and where it cannot be read
  std::int64_t read(std::int64_t first, std::span<std::byte> out);
  /// What the system said where reading failed (an errno); 0 where it did not.
  int error() const { return error_; }

 private:
  int descriptor_ = -1;
  std::span<const std::byte> memory_;
  std::int64_t size_ = 0;
  int error_ = 0;
};

}  // namespace bouncelab::audio
