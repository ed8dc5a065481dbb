// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/sample_files.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/several_files.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

namespace {

struct SampleFile {
  fs::path path;
  RestitutionSamples samples;
};

RestitutionSamples read_one(const fs::path& path, const std::string& columns, std::vector<std::string>& taken_for) {
  ForeignOptions options;
  options.columns = columns;
  const auto reader = open_samples(path, options, taken_for);
  const Table table = reader->next(std::numeric_limits<std::size_t>::max());
  DropsInTurn().check(table, input_name(path));
  return samples_from_table(table, input_name(path));
}

std::string short_name(const fs::path& path) { return path == "-" ? input_name(path) : path.filename().string(); }

void name_recordings(std::vector<SampleFile>& files) {
  std::map<std::string, int> uses;
  for (const SampleFile& file : files) ++uses[short_name(file.path)];
  for (SampleFile& file : files) {
    const std::string name = short_name(file.path);
    for (RestitutionSample& s : file.samples)
      if (s.recording.empty()) s.recording = uses[name] > 1 ? input_name(file.path) : name;
  }
}

/// Recordings of which two files have the same drop.
std::set<std::string> ambiguous_recordings(const std::vector<SampleFile>& files) {
  std::map<std::pair<std::string, std::int64_t>, std::size_t> file_of;
  std::set<std::string> ambiguous;
  for (std::size_t k = 0; k < files.size(); ++k)
    for (const RestitutionSample& s : files[k].samples)
      if (file_of.try_emplace({s.recording, s.drop}, k).first->second != k) ambiguous.insert(s.recording);
  return ambiguous;
}

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

void cut_file(const fs::path& path, RecordingNames& names, std::vector<std::string>& taken_for,
              const TakeRecording& take) {
  const std::string name = input_name(path);
  Cutter cutter(name, names, take);
  const std::unique_ptr<TableReader> reader = open_samples(path, {}, taken_for);
  DropsInTurn drops;
  for (bool at_end = false; !at_end;) {
    const Table piece = reader->next(kPiece_rows);
    drops.check(piece, name);
    at_end = piece.n_rows() < kPiece_rows;
    cutter.add(samples_from_table(piece, name));
  }
  cutter.finish();
}

}  // namespace

RestitutionSamples read_sample_files(const std::vector<fs::path>& paths, int n_threads, const std::string& columns,
                                     std::vector<std::string>& taken_for, std::vector<std::string>& warnings) {
  if (paths.size() == 1) return read_one(paths.front(), columns, taken_for);
  std::vector<SampleFile> files;
  for (const fs::path& path : each_once(paths, n_threads, "samples", warnings))
    files.push_back({path, read_one(path, columns, taken_for)});
  if (files.size() > 1) name_recordings(files);
  const std::set<std::string> ambiguous = ambiguous_recordings(files);
  for (const std::string& name : ambiguous)
    warnings.push_back(printable(name) +
                       ": several files have the same drop of this recording: taken as a recording "
                       "for each file; give the drops numbers of their own if it is one");
  RestitutionSamples all;
  for (SampleFile& file : files)
    for (RestitutionSample& s : file.samples) {
      if (ambiguous.count(s.recording) > 0) s.recording += " (" + input_name(file.path) + ")";
      all.push_back(std::move(s));
    }
  return all;
}

void for_each_recording(const std::vector<fs::path>& files, int n_threads, std::vector<std::string>& warnings,
                        const TakeRecording& take) {
  RecordingNames names;
  for (const fs::path& file : each_once(files, n_threads, "samples", warnings)) {
    names.begin(file);
    cut_file(file, names, warnings, take);
    names.end(warnings);
  }
}

}  // namespace bouncelab::stages
