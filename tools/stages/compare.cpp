// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/loop/analyze.hpp"
#include "bouncelab/loop/comparison.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/stages.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// Impacts of recordings -> their samples.
Outcome read_sounds(const std::vector<fs::path>& files, const CompareOptions& options, const Run& run,
                    const std::function<void(RestitutionSamples&&)>& take) {
  if (files.empty()) return {};
  std::vector<Note> notes = notes_on_provenance(files);
  const std::vector<fs::path> once = each_once(files, run.common.n_threads, "recording", notes);
  const int n_threads = kMayStartChildBesideThreads ? resolved_threads(run.common.n_threads) : 1;
  const Recordings recordings =
      loop::detect_all(once, {}, n_threads, false, progress_line(run, "detect", "recordings"));
  for (const detection::RecordingDetection& recording : recordings) {
    const fit::RestitutionConfig config =
        with_ball(with_conditions_of({recording.recording}, options.restitution, run.given));
    RestitutionSamples samples = fit::restitution_samples(recording.found.onsets, config).samples;
    if (!samples.empty()) take(std::move(samples));
  }
  return detection_outcome(recordings, std::move(notes));
}

}  // namespace

std::vector<Section> sections_of(CompareOptions& options) {
  using O = CompareOptions;
  static constexpr Member own[]{
      member<&O::groups>("groups",
                         "Table of columns recording, plate, date; without it dates in the recordings' names are taken")
          .looks_like("FILE"),
      member<&O::columns>("columns",
                          "Which columns of a table of samples from elsewhere are what: v=COLUMN,eps=COLUMN"),
      member<&O::title>("title", "Title of the page")};
  return {{"", own, &options}, ball_section(options.restitution.world, "not known", {"restitution"})};
}

Outcome run_compare(const CompareOptions& given, const Run& run) {
  CompareOptions options = given;
  // a shell's FOLDER/* names the provenance beside recordings too
  const auto is_provenance = [](const std::string& file) { return file.ends_with(".meta.json"); };
  if (!std::all_of(options.samples.begin(), options.samples.end(), is_provenance))
    std::erase_if(options.samples, is_provenance);
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> inputs(options.samples.begin(), options.samples.end());
  if (!options.groups.empty()) inputs.emplace_back(options.groups);
  check_files(run, inputs, {folder / "comparison.json", folder / "comparison.csv", folder / "report.html"});
  for (const std::string& file : options.samples)
    if (fs::path(file).extension() == ".json")
      throw FileError(file, "is a result, which cannot be compared; give the samples or the sound that it was made of");
  const loop::Origins origins = options.groups.empty() ? loop::Origins{} : read_groups(options.groups);
  const ProgressCallback progress = progress_line(run, "compare", "recordings");
  loop::Comparison comparison;
  const auto take = [&](RestitutionSamples&& samples) {
    comparison.add(std::move(samples));
    progress(static_cast<double>(comparison.n_reduced()), 0.0);
  };
  std::vector<fs::path> sounds, tables;
  for (const std::string& file : options.samples) (holds_times(file, false) ? tables : sounds).emplace_back(file);
  const Outcome heard = read_sounds(sounds, options, run, take);
  Outcome outcome;
  outcome.notes = heard.notes;
  for_each_recording(tables, run.common.n_threads, options.columns, outcome.notes, take);
  loop::ComparedRecordings found = comparison.finish(origins);
  fit::BetweenRecordings& between = found.between;
  if (auto twice = report::note_of_repeated_drops(found.kept)) outcome.notes.push_back(*std::move(twice));
  between.notes = joined(std::move(outcome.notes), between.notes);
  report::order(between.notes);
  outcome.result = report::object_of(between, found.recordings);
  const std::string json = json_text(outcome.result, 1);
  write_text(run, folder / "comparison.json", json + "\n", inputs);
  write_table(run, folder / "comparison.csv", to_table(between, found.recordings), inputs);
  report::ReportInput page;
  page.title = options.title.empty() ? "Recordings: " + stages::name_of_folder(folder) : options.title;
  page.comparison_json = json;
  page.comparison_points_json = report::points_json(between, found.recordings);
  write_text(run, folder / "report.html", report::render(page), inputs);
  outcome.notes = between.notes;
  outcome.exit_code = heard.exit_code;
  outcome.error = heard.error;
  if (const auto& differences = between.differences;
      between.status != fit::FitStatus::ok && (!differences || differences->rows.empty())) {
    outcome.exit_code = std::max<int>(outcome.exit_code, kNotUsable);
    const std::optional<Note>& why = differences && differences->why ? differences->why : between.why;
    outcome.error += (outcome.error.empty() ? "" : "; ") +
                     (differences ? "" : input_name(options.samples.front()) + ": ") +
                     (why ? report::in_words(*why) : "");
    return outcome;
  }
  outcome.text = lines_of(report::in_words(between, found.recordings)) +
                 "Report: " + fs::absolute(folder / "report.html").lexically_normal().string() + "\n";
  return outcome;
}

}  // namespace bouncelab::stages
