// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace bouncelab {

/// The bytes of a file, a quarter of a megabyte at a time: they stay in the cache until they are used, and memory does
/// not grow with the file.
class FileBytes {
 public:
  /// @throws FileError where it cannot be read
  explicit FileBytes(const std::filesystem::path& path);
  FileBytes(FileBytes&&) noexcept;
  FileBytes& operator=(FileBytes&&) noexcept;
  ~FileBytes();

  std::int64_t size() const;

  /// Bytes first ... first + n - 1, until the next call.
  /// @throws FileError where the file holds no such bytes, or no longer
  std::span<const unsigned char> at(std::int64_t first, std::int64_t n);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A whole file as it is, for what is small. Streams of the standard library are no way to it: where memory is short
/// they end early and do not say so.
/// @throws FileError where it cannot be read; std::bad_alloc
std::string whole_content(const std::filesystem::path& path);

}  // namespace bouncelab
