// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace bouncelab {

/// A file that appears whole or not at all: written beside its final place under a hidden name, renamed by commit(),
/// removed by the destructor otherwise (an exception, Ctrl-C).
class OutputFile {
 public:
  /// @throws FileExists where the file exists and may not be replaced; FileError where the folder does not exist or
  ///         cannot be written
  OutputFile(std::filesystem::path path, bool may_replace);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  /// Where to write until commit(); on the same file system, with the same extension.
  const std::filesystem::path& temporary_path() const { return temporary_path_; }
  /// Renames into place. @throws FileError
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  bool committed_ = false;
};

/// Writes `content` whole or not at all. @throws FileError
void write_whole(const std::filesystem::path& path, std::string_view content, bool may_replace);

}  // namespace bouncelab
