// SPDX-License-Identifier: GPL-3.0-or-later
/// Inputs of a command that takes several files of one kind, one after the other.
#pragma once

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace bouncelab::stages {

/// The files with each content once, in their order. Content is compared by size, then by SHA-256, which the provenance
/// needs too. A file that cannot be read has its own content.
/// @param what      they hold: "recording"
/// @param warnings  one line for each file that is left out
std::vector<std::filesystem::path> each_once(const std::vector<std::filesystem::path>& files, int n_threads,
                                             const std::string& what, std::vector<std::string>& warnings);

/// What recordings are called whose rows come from several tables: rows without a recording are of one that is called
/// like the file, and a recording of which an earlier file has rows is one of its own, RECORDING (FILE).
class RecordingNames {
 public:
  /// The rows that follow are those of this file.
  void begin(const std::filesystem::path& file);
  /// @param recording  as the table names it
  const std::string& name(const std::string& recording);
  /// The file has no more rows. @param warnings  get one line where recordings were renamed
  void end(std::vector<std::string>& warnings);

 private:
  std::string file_, given_, name_;  // of the file, and of the last row
  std::set<std::string> of_earlier_files_, of_this_file_;
  std::size_t n_renamed_ = 0;
};

}  // namespace bouncelab::stages
