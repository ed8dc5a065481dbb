// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

constexpr std::size_t kMostRecordings =
    20;  // for people: of thousands of recordings those in which nothing was found, and a sum

/// A recording's name for people.
std::string name_of(const std::filesystem::path& recording) { return printable(input_name(recording)); }

/// Impacts that are likelier than not the ball's; a note tells of the others.
std::size_t n_likely(const detection::RecordingDetection& r) {
  std::size_t n = r.n_onsets;
  for (const Note& note : r.found.notes)
    if (note.kind == NoteKind::improbable_impacts) n -= static_cast<std::size_t>(note.numbers.front());
  return n;
}

/// What was found in a recording, or why nothing was.
std::string found_in(const detection::RecordingDetection& r) {
  if (r.found.status != detection::DetectionStatus::ok) return report::in_words(r.found.notes.front());
  return fmt::format("{} impacts in {} drop{}", n_likely(r), r.found.summary.n_drops,
                     r.found.summary.n_drops == 1 ? "" : "s");
}

/// One line a recording, for people.
std::string describe(const detection::RecordingDetection& r) {
  std::string line = fmt::format("{}: {}", name_of(r.recording), found_in(r));
  if (r.found.summary.restitution_median)
    line += fmt::format(", ε = {:.4f} in the median", *r.found.summary.restitution_median);
  if (r.found.summary.n_channels > 1)
    line += fmt::format("; channel {} ({})", r.found.summary.channel, r.found.summary.channel_reason);
  return line;
}

/// Of one that cannot be read.
const std::string& why(const detection::RecordingDetection& r) { return r.found.notes.front().subject; }

bool is_unreadable(const detection::RecordingDetection& r) {
  return r.found.status == detection::DetectionStatus::unreadable;
}

/// A line a recording; of very many a sum, and a line for each in which nothing was found.
std::string describe_all(const Recordings& recordings) {
  std::vector<std::string> lines;
  std::size_t n_onsets = 0;
  std::int64_t n_drops = 0;
  const bool many = recordings.size() > kMostRecordings;
  for (const detection::RecordingDetection& r : recordings) {
    n_onsets += n_likely(r);
    n_drops += r.found.summary.n_drops;
    if (!is_unreadable(r) && !(many && r.found.status == detection::DetectionStatus::ok)) lines.push_back(describe(r));
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(lines.size(), kMostRecordings); ++k) text += lines[k] + "\n";
  if (lines.size() > kMostRecordings)
    text += fmt::format("... and {} more; with --json all of them are listed\n", lines.size() - kMostRecordings);
  if (many) text += fmt::format("{} impacts in {} drops in {} recordings\n", n_onsets, n_drops, recordings.size());
  return text;
}

/// What went wrong with the recordings as a whole: exit code and error of the outcome.
void conclude(const Recordings& recordings, bool found_any, Outcome& outcome) {
  const auto n_unreadable = std::count_if(recordings.begin(), recordings.end(), is_unreadable);
  if (n_unreadable > 0) {
    const detection::RecordingDetection& first = *std::find_if(recordings.begin(), recordings.end(), is_unreadable);
    outcome.exit_code = kFileError;
    outcome.error = n_unreadable == 1 ? why(first) : fmt::format("{} (and {} more)", why(first), n_unreadable - 1);
  }
  if (!found_any) {
    const auto readable = std::find_if_not(recordings.begin(), recordings.end(), is_unreadable);
    if (readable != recordings.end()) {
      outcome.exit_code = kNotUsable;
      outcome.error = fmt::format(
          "{}: {}; no impacts were written. Listen to it: is it the right recording and channel? Impacts "
          "that you mark by hand can be analyzed too: bouncelab times.csv",
          name_of(readable->recording), found_in(*readable));
    }
    outcome.text.clear();
  } else if (n_unreadable > 0) {
    const auto n_read = std::ssize(recordings) - n_unreadable;
    outcome.error += n_read == 1
                         ? std::string("; the results are those of the one recording that could be read")
                         : fmt::format("; the results are those of the {} recordings that could be read", n_read);
  }
}

/// Files are read in parallel; their onsets go into the table, in the order of the recordings.
Recordings detect_all(const DetectOptions& options, const std::vector<std::filesystem::path>& files, TableWriter& table,
                      const Run& run) {
  Recordings recordings(files.size());
  const auto take = [&](std::size_t k, detection::Detection&& d) {
    table.add(k, to_table(d.onsets));
    recordings[k] = {files[k].string(), d.onsets.size(), std::move(d)};
    if (files.size() == 1) return;
    recordings[k].found.onsets = {};
    recordings[k].found.wave.reset();
    recordings[k].found.noise.reset();
  };
  const ProgressCallback progress = progress_line(run, "detect", files.size() == 1 ? "s of sound" : "recordings");
  const int n_threads = kMayStartChildBesideThreads ? resolved_threads(run.common.n_threads) : 1;
  while_summing(files, n_threads, [&] { detection::detect_each(files, options.config, n_threads, take, progress); });
  return recordings;
}

}  // namespace

std::vector<Section> sections_of(DetectOptions& options) {
  // --drop-height of `restitution`, for the detection: `analyze` sets both by one
  static const Member drop_height = [] {
    const Description all = members_of(static_cast<const fit::RestitutionConfig*>(nullptr));
    return std::find_if(all.begin(), all.end(), [](const Member& m) { return m.name == "drop_height"; })
        ->with(&Member::place, member<&detection::DetectionConfig::drop_height_m>("", "").place);
  }();
  return {section_of(options.config, "Detection"), {"Detection", Description(&drop_height, 1), &options.config}};
}

std::vector<std::filesystem::path> recordings_of(const DetectOptions& options) {
  std::vector<std::filesystem::path> all(options.recordings.begin(), options.recordings.end());
  if (!options.list.empty()) {
    std::ifstream file = open_text(options.list);
    LineReader lines(file, options.list);
    for (std::string line; lines.next(line);) {
      if (line.ends_with('\r')) line.pop_back();
      if (!line.empty()) all.emplace_back(line);
    }
  }
  if (all.empty())
    throw InvalidArgument(options.list.empty() ? "no recording was named; name one, or a list of them with --list"
                                               : "--list " + printable(options.list) + ": names no recording");
  if (all.size() > 1)  // a shell's FOLDER/* names the provenance beside recordings too
    std::erase_if(all, [](const std::filesystem::path& file) { return file.string().ends_with(".meta.json"); });
  return all;
}

std::vector<std::filesystem::path> readable_of(const Recordings& recordings) {
  std::vector<std::filesystem::path> files;
  for (const detection::RecordingDetection& r : recordings)
    if (!is_unreadable(r)) files.emplace_back(r.recording);
  return files;
}

Object summary_of(const Recordings& recordings, const std::vector<Note>& notes) {
  std::size_t n_onsets = 0;
  Values rows;
  for (const detection::RecordingDetection& r : recordings) {
    n_onsets += r.n_onsets;
    Object row = object_of(r);
    row.emplace_back("message", found_in(r));
    rows.push_back(std::move(row));
  }
  return {{"n_onsets", value_of(n_onsets)}, {"recordings", std::move(rows)}, {"notes", report::values_of(notes)}};
}

Outcome detection_outcome(const Recordings& recordings, std::vector<Note> notes) {
  Outcome outcome;
  outcome.notes = joined(std::move(notes), report::notes_of(recordings, true));
  report::order(outcome.notes);
  outcome.text = describe_all(recordings);
  outcome.result = summary_of(recordings, outcome.notes);
  conclude(recordings, first_found(recordings) != nullptr, outcome);
  if (!first_found(recordings)) outcome.notes.clear();  // the error has them
  return outcome;
}

Outcome run_detect(const DetectOptions& options, const Run& run) {
  const std::vector<std::filesystem::path> given = recordings_of(options);
  if (!options.labels.empty() && given.size() > 1)
    throw InvalidArgument("--labels: a label track belongs to one recording; give one");
  std::vector<std::filesystem::path> outputs{options.out, options.labels};
  if (!options.labels.empty()) outputs.push_back(onsets_beside(options.labels));
  check_files(run, given, outputs);
  std::vector<Note> notes;
  const std::vector<std::filesystem::path> files = each_once(given, run.common.n_threads, "recording", notes);
  TableWriter table(run, options.out);
  const Recordings recordings = detect_all(options, files, table, run);
  if (first_found(recordings)) {
    table.finish(readable_of(recordings));
    if (!options.labels.empty())
      write_label_track(run, options.labels, recordings.front().found.onsets, readable_of(recordings));
  }
  return detection_outcome(recordings, std::move(notes));
}

}  // namespace bouncelab::stages
