// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/compare_command.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/report/comparison.hpp"
#include "bouncelab/report/page.hpp"
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
    if (plates != nullptr) origin.plate = (*plates)[k];
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

 private:
  static constexpr std::size_t kMost_samples = 100000;  // some 30 MB
  std::vector<RestitutionSamples> waiting_;
  std::size_t n_samples_ = 0;
};

void name_origins(std::vector<fit::CampaignRecording>& recordings, const Origins& origins, const std::string& file,
                  std::vector<std::string>& warnings) {
  std::set<std::string> found;
  for (fit::CampaignRecording& recording : recordings) {
    const std::string& name = recording.summary.recording;
    if (const auto known = origins.find(name); known != origins.end()) {
      recording.origin = known->second;
      found.insert(name);
    }
    if (!recording.origin.date) recording.origin.date = fit::date_in_name(name);
  }
  if (found.size() < origins.size()) {
    constexpr std::size_t kMostNamed = 5;
    const std::size_t n_missing = origins.size() - found.size();
    std::string names;
    std::size_t n_named = 0;
    for (const auto& [name, origin] : origins)
      if (found.count(name) == 0 && n_named < kMostNamed)
        names += (n_named++ > 0 ? ", '" : "'") + printable(name) + "'";
    if (n_missing > n_named) names += fmt::format(" and {} more", n_missing - n_named);
    warnings.push_back(fmt::format("{} of the {} recordings of {} {} no samples: {}", n_missing, origins.size(),
                                   printable(fs::path(file).filename().string()), n_missing == 1 ? "has" : "have",
                                   names));
  }
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
  for_each_recording({options.samples.begin(), options.samples.end()}, run.common.n_threads, outcome.warnings,
                     [&](RestitutionSamples&& samples) {
                       reduction.take(std::move(samples));
                       if (progress) progress(static_cast<double>(reduction.recordings.size()), 0.0);
                     });
  reduction.reduce();
  std::vector<fit::CampaignRecording>& recordings = reduction.recordings;
  name_origins(recordings, origins, options.groups, outcome.warnings);
  fit::BetweenRecordings between = fit::compare_campaign(recordings);
  between.notes = joined(outcome.warnings, between.notes);
  outcome.warnings = between.notes;
  outcome.result = report::object_of(between, recordings);
  const std::string json = json_text(outcome.result, 1);
  write_text(run, folder / "comparison.json", json + "\n", inputs);
  write_table(run, folder / "comparison.csv", to_table(between, recordings), inputs);
  report::ReportInput page;
  page.title = title_of(options);
  page.comparison_json = json;
  page.comparison_points_json = report::points_json(between, recordings);
  write_text(run, folder / "report.html", report::render(page), inputs);
  if (between.status != fit::FitStatus::ok) {
    outcome.exit_code = kNotUsable;
    outcome.error = input_name(options.samples.front()) + ": " + between.message;
    return outcome;
  }
  for (const std::string& sentence : report::in_words(between, recordings)) outcome.text += sentence + "\n";
  outcome.text += "Report: " + fs::absolute(folder / "report.html").lexically_normal().string() + "\n";
  return outcome;
}

}  // namespace bouncelab::cli
