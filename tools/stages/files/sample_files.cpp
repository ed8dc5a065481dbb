// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/sample_files.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <system_error>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

namespace {

/// Empty where the file cannot be read: what is wrong with it is left to its reader.
std::string sum_if_readable(const fs::path& file) {
  try {
    return sha256_of_file(file);
  } catch (const FileError&) {
    return {};
  }
}

std::uintmax_t size_if_readable(const fs::path& file) {
  try {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(readable(file), error);
    return error ? 0 : size;
  } catch (const FileError&) {
    return 0;
  }
}

/// For each file the index of the first one with the same content, which mostly is its own.
std::vector<std::size_t> first_of_same_content(const std::vector<fs::path>& files, int n_threads) {
  std::map<std::uintmax_t, std::vector<std::size_t>> by_size;
  for (std::size_t k = 0; k < files.size(); ++k) by_size[size_if_readable(files[k])].push_back(k);
  std::vector<std::size_t> of_equal_size;
  for (const auto& [size, equal] : by_size)
    if (size > 0 && equal.size() > 1) of_equal_size.insert(of_equal_size.end(), equal.begin(), equal.end());
  std::vector<std::string> sums(files.size());
  parallel_for(of_equal_size.size(), n_threads,
               [&](std::size_t i) { sums[of_equal_size[i]] = sum_if_readable(files[of_equal_size[i]]); });
  std::vector<std::size_t> first(files.size());
  std::map<std::string, std::size_t> known;
  for (std::size_t k = 0; k < files.size(); ++k)
    first[k] = sums[k].empty() ? k : known.emplace(std::move(sums[k]), k).first->second;
  return first;
}

}  // namespace

std::vector<fs::path> each_once(const std::vector<fs::path>& files, int n_threads, const std::string& what,
                                std::vector<Note>& notes) {
  const std::vector<std::size_t> same = first_of_same_content(files, n_threads);
  std::vector<fs::path> once;
  for (std::size_t k = 0; k < files.size(); ++k)
    if (same[k] == k)
      once.push_back(files[k]);
    else
      notes.push_back(
          {NoteKind::same_content,
           {},
           printable(input_name(files[k])) + ": the same " + what + " as " + printable(input_name(files[same[k]]))});
  return once;
}

void RecordingNames::begin(const fs::path& file) {
  file_ = input_name(file);
  name_.clear();
  n_renamed_ = 0;
}

const std::string& RecordingNames::name(const std::string& recording) {
  if (!name_.empty() && recording == given_) return name_;
  given_ = recording;
  name_ = recording.empty() ? file_ : recording;
  const bool is_new = of_this_file_.insert(name_).second;
  if (of_earlier_files_.contains(name_)) {
    if (is_new) ++n_renamed_;
    name_ += " (" + file_ + ")";
  }
  return name_;
}

void RecordingNames::end(std::vector<Note>& notes) {
  of_earlier_files_.merge(std::exchange(of_this_file_, {}));
  if (n_renamed_ > 0)
    notes.push_back({NoteKind::renamed_recordings, {static_cast<double>(n_renamed_)}, printable(file_)});
}

namespace {

RestitutionSamples read_one(const fs::path& path, const std::string& columns, std::vector<std::string>& taken_for) {
  ForeignOptions options;
  options.columns = columns;
  TableReader reader = open_samples(path, options, taken_for);
  const Table table = reader.next(std::numeric_limits<std::size_t>::max());
  DropsInTurn().check(table, input_name(path));
  return samples_from_table(table, input_name(path));
}

using TakeRecording = std::function<void(RestitutionSamples&&)>;

/// Cuts the rows of a file, which come in pieces, into recordings.
void cut_file(const fs::path& path, const std::string& columns, RecordingNames& names,
              std::vector<std::string>& taken_for, const TakeRecording& take) {
  const std::string name = input_name(path);
  std::set<std::string> finished;
  RestitutionSamples recording;
  const auto finish = [&] {
    if (recording.empty()) return;
    const std::string& called = recording.front().recording;
    if (!finished.insert(called).second)
      throw FileError(
          name, "the samples of recording '" + printable(called) + "' are not together; sort the table by recording");
    take(std::exchange(recording, {}));
  };
  ForeignOptions options;
  options.columns = columns;
  TableReader reader = open_samples(path, options, taken_for);
  DropsInTurn drops;
  for (bool at_end = false; !at_end;) {
    const Table piece = reader.next(kPiece_rows);
    drops.check(piece, name);
    at_end = piece.n_rows() < kPiece_rows;
    for (RestitutionSample& row : samples_from_table(piece, name)) {
      row.recording = names.name(row.recording);
      if (!recording.empty() && recording.front().recording != row.recording) finish();
      recording.push_back(std::move(row));
    }
  }
  finish();
}

}  // namespace

RestitutionSamples read_sample_files(const std::vector<fs::path>& paths, int n_threads, const std::string& columns,
                                     std::vector<std::string>& taken_for, std::vector<Note>& notes) {
  if (paths.size() == 1) return read_one(paths.front(), columns, taken_for);
  RecordingNames names;
  RestitutionSamples all;
  for (const fs::path& path : each_once(paths, n_threads, "samples", notes)) {
    names.begin(path);
    for (RestitutionSample& s : read_one(path, columns, taken_for)) {
      s.recording = names.name(s.recording);
      all.push_back(std::move(s));
    }
    names.end(notes);
  }
  return all;
}

void for_each_recording(const std::vector<fs::path>& files, int n_threads, const std::string& columns,
                        std::vector<Note>& notes, const TakeRecording& take) {
  RecordingNames names;
  std::vector<std::string> taken_for;
  for (const fs::path& file : each_once(files, n_threads, "samples", notes)) {
    names.begin(file);
    cut_file(file, columns, names, taken_for, take);
    names.end(notes);
  }
  for (std::string& what : one_a_kind(taken_for)) notes.push_back({NoteKind::of_file, {}, std::move(what)});
}

loop::Origins read_groups(const fs::path& path) {
  const std::string name = input_name(path);
  const Table table = read_table(path, {{"recording", ColumnType::text},
                                        {"plate", ColumnType::text, false},
                                        {"date", ColumnType::text, false},
                                        {"day", ColumnType::text, false}});
  const auto *recordings = table.texts("recording"), *plates = table.texts("plate"), *dates = table.texts("date");
  if (const auto* days = table.texts("day"); days && !dates && !days->empty() && fit::date_from_iso(days->front()))
    throw FileError(name, "the dates stand in a column day; call it date");
  if (plates == nullptr && dates == nullptr)
    throw FileError(name, "there is neither a column plate nor a column date; add one, or leave --groups out");
  loop::Origins origins{{}, printable(path.filename().string())};
  for (std::size_t k = 0; k < recordings->size(); ++k) {
    fit::RecordingOrigin origin;
    if (plates != nullptr) origin.plate = std::string(cells_of((*plates)[k], '\n').front());  // without blanks around
    if (dates != nullptr && !(*dates)[k].empty()) {
      origin.date = fit::date_from_iso((*dates)[k]);
      if (!origin.date)
        throw FileError(name, table.place_of(k) + ", column date: '" + printable((*dates)[k]) +
                                  "' is no date from 1990 to 2100; write 2026-11-23 or 2026-11-23T14:05");
    }
    if (!origins.by_recording.emplace((*recordings)[k], origin).second)
      throw FileError(name, table.place_of(k) + ", column recording: '" + printable((*recordings)[k]) +
                                "' stands there twice; keep one of its rows");
  }
  return origins;
}

fit::Plates plates_of(const RestitutionSamples& samples, const fs::path& groups, std::vector<Note>& notes) {
  const loop::Origins origins = read_groups(groups);
  if (std::all_of(origins.by_recording.begin(), origins.by_recording.end(),
                  [](const auto& row) { return row.second.plate.empty(); }))
    throw FileError(input_name(groups), "names no plate; fill its column plate, or leave --groups out");
  std::set<std::string> recordings;
  for (const RestitutionSample& s : samples) recordings.insert(s.recording);
  const std::vector<std::string> names(recordings.begin(), recordings.end());
  const std::vector<fit::RecordingOrigin> of_names = loop::origins_of(names, origins, notes);
  fit::Plates plates;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (!of_names[k].plate.empty()) plates[names[k]] = of_names[k].plate;
  return plates;
}

}  // namespace bouncelab::stages
