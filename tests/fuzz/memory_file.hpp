// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace bouncelab::fuzz {

/// A file that exists in memory only, for readers that take a path.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content = {});
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile();

  const std::filesystem::path& path() const { return path_; }
  std::string content() const;

 private:
  int descriptor_ = -1;
  std::filesystem::path path_;
};

}  // namespace bouncelab::fuzz
