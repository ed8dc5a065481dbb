// SPDX-License-Identifier: GPL-3.0-or-later
/// Inputs of a command that takes several files of one kind, one after the other.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "bouncelab/core/note.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/recordings.hpp"
#include "bouncelab/loop/comparison.hpp"

namespace bouncelab::stages {

/// The files with each content once, in their order. Content is compared by size, then by SHA-256, which the provenance
/// needs too. A file that cannot be read has its own content.
/// @param what      they hold: "recording"
/// @param notes  one line for each file that is left out
std::vector<std::filesystem::path> each_once(const std::vector<std::filesystem::path>& files, int n_threads,
                                             const std::string& what, std::vector<Note>& notes);

/// What recordings are called whose rows come from several tables: rows without a recording are of one that is called
/// like the file, and a recording of which an earlier file has rows is one of its own, RECORDING (FILE).
class RecordingNames {
 public:
  /// The rows that follow are those of this file.
  void begin(const std::filesystem::path& file);
  /// @param recording  as the table names it
  const std::string& name(const std::string& recording);
  /// The file has no more rows. @param notes  get one line where recordings were renamed
  void end(std::vector<Note>& notes);

 private:
  std::string file_, given_, name_;  // of the file, and of the last row
  std::set<std::string> of_earlier_files_, of_this_file_;
  std::size_t n_renamed_ = 0;
};

/// Samples of several files, one after the other; those of the same content count once. Of more than one their
/// recordings are called as RecordingNames has it.
/// @param columns    of tables that are not ours: ForeignOptions::columns
/// @param taken_for  a line for each of those
/// @param notes  one line for each file that was left out and each recording that was renamed
/// @throws FileError
RestitutionSamples read_sample_files(const std::vector<std::filesystem::path>& files, int n_threads,
                                     const std::string& columns, std::vector<std::string>& taken_for,
                                     std::vector<Note>& notes);

/// Calls `take` with the samples of each recording of the files, in their order, and holds no more than one recording
/// and a piece of the file at a time. Samples without a recording get the file's name.
/// A recording of the same name in a later file is one of its own: `RECORDING (FILE)`. Files of the same content count
/// once.
/// @param columns  of tables that are not ours: ForeignOptions::columns
/// @param notes  one line for each file that is left out, and for each file whose recordings were renamed
/// @throws FileError; naming the recording whose rows are not together
void for_each_recording(const std::vector<std::filesystem::path>& files, int n_threads, const std::string& columns,
                        std::vector<Note>& notes, const std::function<void(RestitutionSamples&&)>& take);

/// A table of columns recording and plate or date. @throws FileError
loop::Origins read_groups(const std::filesystem::path& path);

/// The plate of each of the samples' recordings that has one in the table. @throws FileError where it has no plates
fit::Plates plates_of(const RestitutionSamples& samples, const std::filesystem::path& groups, std::vector<Note>& notes);

}  // namespace bouncelab::stages
