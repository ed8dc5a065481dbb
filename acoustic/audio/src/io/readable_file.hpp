// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
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

}  // namespace bouncelab::audio
