// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/analyze_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/report/detection.hpp"
#include "stages/files/several_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"
#include "stages/report.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"onsets.csv",       "samples.csv",  "fit.json",   "wave.json",
                                "diagnostics.json", "summary.json", "report.html"};

std::string title_of(const Recordings& recordings) {
  const std::string first = fs::path(input_name(recordings.front().recording)).filename().string();
  return recordings.size() == 1 ? "Restitution from " + first
                                : fmt::format("Restitution from {} and {} more", first, recordings.size() - 1);
}

void write_json(const Run& run, const fs::path& path, const Value& value, int indent,
                const std::vector<fs::path>& inputs) {
  write_text(run, path, json_text(value, indent) + "\n", inputs);
}

void write_files(const loop::Analysis& found, const report::FitInWords& words, const fs::path& folder, const Run& run) {
  write_table(run, folder / "onsets.csv", to_table(loop::onsets_of(found.recordings)), readable_of(found.recordings));
  write_table(run, folder / "samples.csv", to_table(found.restitution.samples), {folder / "onsets.csv"});
  write_json(run, folder / "fit.json", report::object_of(found.fit, words), 1, {folder / "samples.csv"});
  write_json(run, folder / "wave.json", value_of(*found.wave), -1, {first_found(found.recordings)->recording});
  // the report shows what lies in the folder: details of an earlier run must not stay in it
  for (const char* old : {"diagnostics.json", "diagnostics.json.meta.json"}) fs::remove(folder / old);
  if (found.details.empty()) return;
  std::vector<fs::path> recordings;
  for (const loop::RecordingDetails& d : found.details) recordings.emplace_back(d.recording);
  write_json(run, folder / "diagnostics.json", Object{{"recordings", value_of(found.details)}}, -1, recordings);
}

}  // namespace

loop::AnalyzeConfig analyze_config(const AnalyzeOptions& options, const CommonOptions& common) {
  return {options.detect.config, restitution_config(options.restitution), fit_config(options.fit, common),
          options.diagnostics, kMayStartChildBesideThreads ? resolved_threads(common.n_threads) : 1};
}

Outcome run_analyze(const AnalyzeOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> outputs;
  for (const char* name : kOutputs) outputs.push_back(folder / name);
  const std::vector<fs::path> given = recordings_of(options.detect);
  check_files(run, given, outputs);
  std::vector<std::string> warnings;
  const std::vector<fs::path> files = each_once(given, run.common.n_threads, "recording", warnings);
  const loop::AnalyzeConfig config = analyze_config(options, run.common);
  loop::Analysis found;
  // the checksums of the provenance while the sound is searched, as a thread has time for them
  parallel_for(2, config.n_threads, [&](std::size_t work) {
    if (work == 1) return compute_sha256_ahead(files, config.n_threads);
    found = loop::analyze(files, config, stage_progress(run));
  });
  return write_analysis(found, config, std::move(warnings), folder, run);
}

Outcome write_analysis(const loop::Analysis& found, const loop::AnalyzeConfig& config,
                       std::vector<std::string> warnings, const fs::path& folder, const Run& run) {
  Outcome detected = detection_outcome(found.recordings, std::move(warnings));
  if (!first_found(found.recordings)) return detected;
  report::FitInWords words = report::in_words(found.fit, found.restitution.samples, config.fit.memory);
  const Outcome fitted = as_stage(fit_outcome(found.fit, words, (folder / "samples.csv").string()), found.fit);
  Outcome outcome;
  outcome.warnings = joined(report::warnings_of(found.restitution.counts, config.restitution), detected.warnings);
  outcome.warnings = joined(outcome.warnings, fitted.warnings);
  if (found.recordings.size() == 1) report::keep_three(outcome.warnings, words);
  write_files(found, words, folder, run);
  outcome.result = object_of(members_of(&found), &found);
  outcome.result.emplace_back("answer", value_of(words.answer));
  outcome.result.emplace_back("warnings", outcome.warnings);
  write_json(run, folder / "summary.json", outcome.result, 2, {folder / "fit.json"});
  const Outcome shown = run_report({folder, folder / "report.html", title_of(found.recordings)}, run);
  const std::string answer = answer_text(words.answer);
  outcome.text = answer + detected.text + text_of(found.restitution.counts, config.restitution) + shown.text;
  outcome.exit_code = std::max(detected.exit_code, fitted.exit_code);
  // recordings that were left out are named also where the fit of the others fails
  outcome.error = detected.error + (detected.error.empty() || fitted.error.empty() ? "" : "; ") + fitted.error;
  return outcome;
}

}  // namespace bouncelab::cli
