// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace bouncelab::audio {

/// An input (bouncelab::readable) open for reading at any place, closed at the end.
class ReadableFile {
 public:
  /// @throws FileError: missing, a folder, empty, not to be read; Interrupted
  explicit ReadableFile(const std::filesystem::path& path);
  ReadableFile(const ReadableFile&) = delete;
  ReadableFile& operator=(const ReadableFile&) = delete;
  ~ReadableFile();

  int descriptor() const { return descriptor_; }
  /// For messages.
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  int descriptor_ = -1;
};

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
  /// At most n bytes from `first` on.
  std::string text(std::int64_t first, std::size_t n);
  /// @throws FileError where reading failed, with the system's reason. @param name  of the file
  void check(const std::string& name) const;

 private:
  int descriptor_ = -1;
  std::span<const std::byte> memory_;
  std::int64_t size_ = 0;
  int error_ = 0;  // errno
};

}  // namespace bouncelab::audio
