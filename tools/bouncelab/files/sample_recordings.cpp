// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/sample_recordings.hpp"

#include <memory>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/text.hpp"
#include "files/same_content.hpp"
#include "files/table_file.hpp"

namespace bouncelab::cli {
namespace {

using TakeRecording = std::function<void(RestitutionSamples&&)>;

/// Cuts rows, which come in pieces, into recordings.
class Cutter {
 public:
  Cutter(std::string name, std::set<std::string>& of_other_files, TakeRecording take)
      : name_(std::move(name)), of_other_files_(of_other_files), take_(std::move(take)) {}

  void add(RestitutionSamples&& rows) {
    for (RestitutionSample& row : rows) {
      if (row.recording.empty()) row.recording = name_;
      if (!recording_.empty() && recording_.front().recording != row.recording) finish();
      recording_.push_back(std::move(row));
    }
  }
  void finish() {
    if (recording_.empty()) return;
    const std::string recording = recording_.front().recording;
    if (!of_this_file_.insert(recording).second)
      throw FileError(name_, "the samples of recording '" + printable(recording) +
                                 "' are not together; sort the table by recording");
    if (of_other_files_.count(recording) > 0) {
      ++n_renamed_;
      for (RestitutionSample& row : recording_) row.recording += " (" + name_ + ")";
    }
    take_(std::exchange(recording_, {}));
  }
  /// @return how many recordings were renamed
  std::size_t end_of_file() {
    finish();
    of_other_files_.merge(of_this_file_);
    return n_renamed_;
  }

 private:
  std::string name_;
  std::set<std::string>& of_other_files_;
  TakeRecording take_;
  std::set<std::string> of_this_file_;
  RestitutionSamples recording_;
  std::size_t n_renamed_ = 0;
};

void cut_file(const std::filesystem::path& path, Cutter& cutter) {
  const std::string name = input_name(path);
  const std::unique_ptr<TableReader> reader = open_table(path, sample_columns());
  for (bool at_end = false; !at_end;) {
    const Table piece = reader->next(kPiece_rows);
    at_end = piece.n_rows() < kPiece_rows;
    cutter.add(samples_from_table(piece, name));
  }
}

}  // namespace

void for_each_recording(const std::vector<std::filesystem::path>& files, int n_threads,
                        std::vector<std::string>& warnings, const TakeRecording& take) {
  const std::vector<std::size_t> same = first_of_same_content(files, n_threads);
  std::set<std::string> names;
  for (std::size_t k = 0; k < files.size(); ++k) {
    const std::string name = printable(input_name(files[k]));
    if (same[k] != k) {
      warnings.push_back(name + ": the same samples as " + printable(input_name(files[same[k]])) +
                         " (by content); counted once");
      continue;
    }
    Cutter cutter(input_name(files[k]), names, take);
    cut_file(files[k], cutter);
    if (const std::size_t n = cutter.end_of_file(); n > 0)
      warnings.push_back(name + ": " + std::to_string(n) +
                         " recordings have the names of recordings in another file: taken as others, with the file's "
                         "name behind");
  }
}

}  // namespace bouncelab::cli
