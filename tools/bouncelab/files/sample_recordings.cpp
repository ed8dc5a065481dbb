// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/sample_recordings.hpp"

#include <memory>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/printable.hpp"
#include "files/several_files.hpp"
#include "files/table_file.hpp"

namespace bouncelab::cli {
namespace {

using TakeRecording = std::function<void(RestitutionSamples&&)>;

/// Cuts rows, which come in pieces, into recordings.
class Cutter {
 public:
  Cutter(std::string file, RecordingNames& names, TakeRecording take)
      : file_(std::move(file)), names_(names), take_(std::move(take)) {}

  void add(RestitutionSamples&& rows) {
    for (RestitutionSample& row : rows) {
      row.recording = names_.name(row.recording);
      if (!recording_.empty() && recording_.front().recording != row.recording) finish();
      recording_.push_back(std::move(row));
    }
  }
  void finish() {
    if (recording_.empty()) return;
    const std::string& recording = recording_.front().recording;
    if (!finished_.insert(recording).second)
      throw FileError(file_, "the samples of recording '" + printable(recording) +
                                 "' are not together; sort the table by recording");
    take_(std::exchange(recording_, {}));
  }

 private:
  std::string file_;
  RecordingNames& names_;
  TakeRecording take_;
  std::set<std::string> finished_;
  RestitutionSamples recording_;
};

void cut_file(const std::filesystem::path& path, RecordingNames& names, const TakeRecording& take) {
  const std::string name = input_name(path);
  Cutter cutter(name, names, take);
  const std::unique_ptr<TableReader> reader = open_table(path, sample_columns());
  for (bool at_end = false; !at_end;) {
    const Table piece = reader->next(kPiece_rows);
    at_end = piece.n_rows() < kPiece_rows;
    cutter.add(samples_from_table(piece, name));
  }
  cutter.finish();
}

}  // namespace

void for_each_recording(const std::vector<std::filesystem::path>& files, int n_threads,
                        std::vector<std::string>& warnings, const TakeRecording& take) {
  RecordingNames names;
  for (const std::filesystem::path& file : each_once(files, n_threads, "samples", warnings)) {
    names.begin(file);
    cut_file(file, names, take);
    names.end(warnings);
  }
}

}  // namespace bouncelab::cli
