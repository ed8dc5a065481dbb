// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/comparison.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/detect.hpp"
#include "stages/files/fit_file.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

using Origins = std::map<std::string, fit::RecordingOrigin>;

/// Plates and dates by recording.
Origins read_groups(const fs::path& path) {
  const std::string name = input_name(path);
  const Table table = read_table(
      path, {{"recording", ColumnType::text}, {"plate", ColumnType::text, false}, {"date", ColumnType::text, false}});
  const auto *recordings = table.texts("recording"), *plates = table.texts("plate"), *dates = table.texts("date");
  if (plates == nullptr && dates == nullptr)
    throw FileError(name, "there is neither a column plate nor a column date; add one, or leave --groups out");
  Origins origins;
  for (std::size_t k = 0; k < recordings->size(); ++k) {
    fit::RecordingOrigin origin;
    if (plates != nullptr) origin.plate = std::string(cells_of((*plates)[k], '\n').front());  // without blanks around
    if (dates != nullptr && !(*dates)[k].empty()) {
      origin.date = fit::date_from_iso((*dates)[k]);
      if (!origin.date)
        throw FileError(name, table.place_of(k) + ", column date: '" + printable((*dates)[k]) +
                                  "' is no date from 1990 to 2100; write 2026-11-23 or 2026-11-23T14:05");
    }
    if (!origins.emplace((*recordings)[k], origin).second)
      throw FileError(name, table.place_of(k) + ", column recording: '" + printable((*recordings)[k]) +
                                "' stands there twice; keep one of its rows");
  }
  return origins;
}

/// Reduces recordings as they are read, some at a time on all threads.
class Reduction {
 public:
  void take(RestitutionSamples&& samples) {
    n_samples_ += samples.size();
    if (kept.size() < kMostKept) kept.push_back(samples);
    waiting_.push_back(std::move(samples));
    if (n_samples_ > kMost_samples) reduce();
  }
  void reduce() {
    const std::size_t first = recordings.size();
    recordings.resize(first + waiting_.size());
    parallel_for(waiting_.size(), 0,
                 [&](std::size_t k) { recordings[first + k].summary = fit::summarize_recording(waiting_[k]); });
    waiting_.clear();
    n_samples_ = 0;
  }
  std::vector<fit::CampaignRecording> recordings;
  std::vector<RestitutionSamples> kept;  ///< of the first kMostKept recordings

 private:
  static constexpr std::size_t kMost_samples = 100000;  // some 30 MB
  static constexpr std::size_t kMostKept = 100;         // of few plates; of more recordings the summaries say enough
  std::vector<RestitutionSamples> waiting_;
  std::size_t n_samples_ = 0;
};

/// "2 of the 5 recordings WHAT: 'a', 'b'"
std::string name_some(const std::vector<std::string>& names, std::size_t n_all, const std::string& what) {
  constexpr std::size_t kMostNamed = 5;
  std::string text;
  for (std::size_t k = 0; k < std::min(names.size(), kMostNamed); ++k)
    text += (k > 0 ? ", '" : "'") + printable(names[k]) + "'";
  if (names.size() > kMostNamed) text += fmt::format(" and {} more", names.size() - kMostNamed);
  return fmt::format("{} of the {} recordings {}: {}", names.size(), n_all, what, text);
}

/// The row of a recording: by its name, else by the name of its file.
Origins::const_iterator row_of(const std::string& recording, const Origins& origins) {
  const auto known = origins.find(recording);
  return known != origins.end() ? known : origins.find(fs::path(recording).filename().string());
}

/// Rows of the table without a recording, and recordings without a row, are named.
void name_origins(std::vector<fit::CampaignRecording>& recordings, const Origins& origins, const std::string& file,
                  std::vector<Note>& notes) {
  std::set<std::string> found;
  std::vector<std::string> without_row, without_samples;
  for (fit::CampaignRecording& recording : recordings) {
    const std::string& name = recording.summary.recording;
    if (const auto known = row_of(name, origins); known != origins.end()) {
      recording.origin = known->second;
      found.insert(known->first);
    } else {
      without_row.push_back(name);
    }
    if (!recording.origin.date) recording.origin.date = fit::date_in_name(name);
  }
  if (origins.empty()) return;
  const std::string table = printable(fs::path(file).filename().string());
  for (const auto& [name, origin] : origins)
    if (!found.contains(name)) without_samples.push_back(name);
  if (!without_samples.empty())
    notes.push_back({NoteKind::rows_without_samples,
                     {},
                     name_some(without_samples, origins.size(),
                               "of " + table + (without_samples.size() == 1 ? " has" : " have") + " no samples")});
  if (!without_row.empty())
    notes.push_back({NoteKind::no_row,
                     {},
                     name_some(without_row, recordings.size(),
                               std::string(without_row.size() == 1 ? "has" : "have") + " no row in " + table)});
}

/// Impacts of recordings -> their samples.
Outcome read_sounds(const std::vector<fs::path>& files, const CompareOptions& options, const Run& run,
                    const std::function<void(RestitutionSamples&&)>& take) {
  if (files.empty()) return {};
  std::vector<Note> notes;
  const std::vector<fs::path> once = each_once(files, run.common.n_threads, "recording", notes);
  std::vector<detection::RecordingDetection> recordings(once.size());
  const int n_threads = kMayStartChildBesideThreads ? resolved_threads(run.common.n_threads) : 1;
  detection::detect_each(
      once, {}, n_threads,
      [&](std::size_t k, detection::Detection&& found) {
        recordings[k] = {once[k].string(), found.onsets.size(), std::move(found)};
      },
      progress_line(run, "detect", "recordings"));
  for (const detection::RecordingDetection& recording : recordings) {
    const fit::RestitutionConfig config =
        restitution_config(with_conditions_of({recording.recording}, options.restitution, run.given));
    RestitutionSamples samples = fit::restitution_samples(recording.found.onsets, config).samples;
    if (!samples.empty()) take(std::move(samples));
  }
  return detection_outcome(recordings, std::move(notes));
}

using Groups = std::vector<std::pair<std::string, RestitutionSamples>>;

/// Plates where there are two to four, else two to four recordings; otherwise none.
/// @param kept  samples of the first recordings, in their order
Groups groups_of(const std::vector<fit::CampaignRecording>& recordings, const fit::BetweenRecordings& between,
                 const std::vector<RestitutionSamples>& kept) {
  if (kept.size() < recordings.size()) return {};
  std::map<std::string, RestitutionSamples> plates;
  Groups alone;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    if (between.rows[k].is_outlier) continue;
    fit::LeftOut left_out;
    const fit::PartOfSamples usable = fit::usable_samples(kept[k], left_out);
    alone.emplace_back(recordings[k].summary.recording, *usable);
    const std::string& plate = recordings[k].origin.plate;
    if (!plate.empty()) plates[plate].insert(plates[plate].end(), usable->begin(), usable->end());
  }
  std::set<std::string> file_names;
  for (const auto& [name, samples] : alone) file_names.insert(fs::path(name).filename().string());
  if (file_names.size() == alone.size())
    for (auto& [name, samples] : alone) name = fs::path(name).filename().string();
  const auto are_few = [](std::size_t n) { return n >= 2 && n <= fit::kMostGroups; };
  if (are_few(plates.size())) return {plates.begin(), plates.end()};
  return plates.empty() && are_few(alone.size()) ? alone : Groups{};
}

std::string title_of(const CompareOptions& options) {
  if (!options.title.empty()) return options.title;
  const fs::path path = fs::absolute(options.out).lexically_normal();
  return "Recordings: " + (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

}  // namespace

Outcome run_compare(const CompareOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> inputs(options.samples.begin(), options.samples.end());
  if (!options.groups.empty()) inputs.emplace_back(options.groups);
  check_files(run, inputs, {folder / "comparison.json", folder / "comparison.csv", folder / "report.html"});
  Outcome outcome;
  const Origins origins = options.groups.empty() ? Origins{} : read_groups(options.groups);
  const ProgressCallback progress = progress_line(run, "compare", "recordings");
  Reduction reduction;
  std::vector<std::string> of_named_balls, of_others, of_other_conditions;
  std::optional<SampleConditions> first;
  const auto take = [&](RestitutionSamples&& samples) {
    const bool is_named = !samples.empty() && samples.front().conditions.ball;
    (is_named ? of_named_balls : of_others).push_back(samples.empty() ? "" : samples.front().recording);
    const std::string& recording = (is_named ? of_named_balls : of_others).back();
    if (is_named) samples = fit::at_the_plate(std::move(samples));
    if (!samples.empty()) {
      const SampleConditions& here = samples.front().conditions;
      if (!first) first = here;
      if (here != *first && here.ball.has_value() == first->ball.has_value()) of_other_conditions.push_back(recording);
    }
    reduction.take(std::move(samples));
    if (progress) progress(static_cast<double>(reduction.recordings.size()), 0.0);
  };
  for (const std::string& file : options.samples)
    if (fs::path(file).extension() == ".json" && stages::is_fit(whole_content(file)))
      throw FileError(file, "is a result, which cannot be compared; give the samples or the sound that it was made of");
  std::vector<fs::path> sounds, tables;
  for (const std::string& file : options.samples) (holds_times(file, false) ? tables : sounds).emplace_back(file);
  const Outcome heard = read_sounds(sounds, options, run, take);
  outcome.notes = heard.notes;
  for_each_recording(tables, run.common.n_threads, outcome.notes, take);
  reduction.reduce();
  std::vector<fit::CampaignRecording>& recordings = reduction.recordings;
  if (!of_named_balls.empty() && !of_others.empty())
    outcome.notes.push_back({NoteKind::no_ball_named,
                             {},
                             name_some(of_others, recordings.size(), of_others.size() == 1 ? "names" : "name")});
  if (!of_other_conditions.empty())
    outcome.notes.push_back(
        {NoteKind::other_conditions,
         {},
         name_some(of_other_conditions, recordings.size(), of_other_conditions.size() == 1 ? "is" : "are")});
  RestitutionSamples kept;
  for (const RestitutionSamples& samples : reduction.kept) {
    fit::LeftOut left_out;
    const fit::PartOfSamples usable = fit::usable_samples(samples, left_out);
    kept.insert(kept.end(), usable->begin(), usable->end());
  }
  if (auto twice = report::note_of_repeated_drops(kept)) outcome.notes.push_back(*std::move(twice));
  name_origins(recordings, origins, options.groups, outcome.notes);
  fit::BetweenRecordings between = fit::compare_campaign(recordings);
  between.notes = joined(outcome.notes, between.notes);
  report::order(between.notes);
  outcome.notes = between.notes;
  std::optional<fit::GroupDifferences> differences;
  if (const Groups groups = groups_of(recordings, between, reduction.kept); !groups.empty())
    differences = fit::compare_groups(groups);
  outcome.result = report::object_of(between, recordings, differences);
  const std::string json = json_text(outcome.result, 1);
  write_text(run, folder / "comparison.json", json + "\n", inputs);
  write_table(run, folder / "comparison.csv", to_table(between, recordings), inputs);
  report::ReportInput page;
  page.title = title_of(options);
  page.comparison_json = json;
  page.comparison_points_json = report::points_json(between, recordings);
  write_text(run, folder / "report.html", report::render(page), inputs);
  outcome.exit_code = heard.exit_code;
  outcome.error = heard.error;
  if (between.status != fit::FitStatus::ok && (!differences || differences->rows.empty())) {
    outcome.exit_code = std::max<int>(outcome.exit_code, kNotUsable);
    const std::optional<Note>& note = differences && differences->why ? differences->why : between.why;
    const std::string why = note ? report::in_words(*note) : "";
    outcome.error +=
        (outcome.error.empty() ? "" : "; ") + (differences ? "" : input_name(options.samples.front()) + ": ") + why;
    return outcome;
  }
  for (const std::string& sentence : report::in_words(between, recordings, differences))
    outcome.text += sentence + "\n";
  outcome.text += "Report: " + fs::absolute(folder / "report.html").lexically_normal().string() + "\n";
  return outcome;
}

}  // namespace bouncelab::cli
