// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/analyze_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "commands/report_command.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"
#include "json/wave_json.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"onsets.csv",       "samples.csv",  "fit.json",   "wave.json",
                                "diagnostics.json", "summary.json", "report.html"};

std::string title_of(const std::vector<RecordingResult>& recordings) {
  const std::string first = fs::path(input_name(recordings.front().recording)).filename().string();
  return recordings.size() == 1 ? "Restitution from " + first
                                : fmt::format("Restitution from {} and {} more", first, recordings.size() - 1);
}

/// The report shows the sound of the first recording in which impacts were found.
void write_wave_of_first(const DetectResult& found, const fs::path& out, std::optional<double> rate_hz,
                         const Run& run) {
  const auto& [k, first] = *found.first.begin();
  const fs::path recording = found.recordings[k].recording;
  write_text(run, out,
             wave_json(detection::wave_preview(recording, first.summary.channel, first.onsets, rate_hz)) + "\n",
             {recording});
}

constexpr std::int64_t kDropsShown = kMostDetections;  // so many recordings have at least so many drops

RestitutionSamples read_samples(const fs::path& path) {
  return samples_from_table(read_table(path, sample_columns()), path.string());
}

/// The details of the first drops of all recordings (at most kDropsShown).
std::vector<RecordingDetails> details_of(const DetectResult& found, const RestitutionSamples& samples,
                                         const std::optional<RestitutionLaw>& law, double gravity_mps2,
                                         std::optional<double> rate_hz) {
  std::vector<RecordingDetails> all;
  std::int64_t n_shown = 0;
  for (const auto& [k, d] : found.first) {
    if (n_shown >= kDropsShown) break;
    const std::string& recording = found.recordings[k].recording;
    const std::string name = input_name(recording);
    RecordingDetails details{recording, d.summary.n_drops, d.wave, d.noise, {}};
    audio::AudioReader reader(recording, rate_hz);
    const auto sound = reader.source(d.summary.channel);
    for (std::int64_t drop = 0; drop < d.summary.n_drops && n_shown < kDropsShown; ++drop, ++n_shown)
      details.drops.push_back({detection::drop_preview(sound, name, d.summary.channel, d.onsets, drop),
                               fit::predict_intervals(samples, name, drop, law, gravity_mps2)});
    all.push_back(std::move(details));
  }
  return all;
}

void write_diagnostics(const std::vector<RecordingDetails>& details, const fs::path& out, const Run& run) {
  std::vector<fs::path> recordings;
  for (const RecordingDetails& d : details) recordings.emplace_back(d.recording);
  write_text(run, out, diagnostics_json(details) + "\n", recordings);
}

/// Onsets -> samples -> fit, in the folder.
struct Constants {
  Stage<fit::RestitutionCounts> samples;
  Stage<Fitted> fit;
};

Constants times_to_constants(const AnalyzeOptions& options, const fs::path& folder, const Run& run, StageClock& clock) {
  Constants constants;
  RestitutionOptions restitution = options.restitution;
  restitution.onsets = {folder / "onsets.csv"};
  restitution.out = folder / "samples.csv";
  constants.samples = clock.time("restitution", [&] { return run_restitution(restitution, run); });
  FitOptions fit = options.fit;
  fit.samples = {restitution.out};
  fit.out = folder / "fit.json";
  constants.fit = clock.time("fit", [&] { return as_stage(run_fit(fit, run)); });
  return constants;
}

}  // namespace

Outcome run_analyze(const AnalyzeOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> outputs;
  for (const char* name : kOutputs) outputs.push_back(folder / name);
  check_files(run, recordings_of(options.detect), outputs);
  StageClock clock;
  DetectOptions detect = options.detect;
  detect.out = folder / "onsets.csv";
  const Stage<DetectResult> found = clock.time("detect", [&] { return run_detect(detect, run); });
  if (found.result.first.empty()) return found.outcome;
  return analyze_found(options, found, run, clock);
}

Outcome analyze_found(const AnalyzeOptions& options, const Stage<DetectResult>& detection, const Run& run,
                      StageClock& clock) {
  const auto& [detected, found] = detection;
  const fs::path folder = options.out;
  const auto [samples, fit] = times_to_constants(options, folder, run, clock);
  const std::vector<std::string> warnings =
      joined(joined(detected.warnings, samples.outcome.warnings), fit.outcome.warnings);

  const std::optional<double> rate_hz = options.detect.config.rate_hz;
  write_wave_of_first(found, folder / "wave.json", rate_hz, run);
  // the report shows what lies in the folder: details of an earlier run must not stay in it
  for (const char* old : {"diagnostics.json", "diagnostics.json.meta.json"}) fs::remove(folder / old);
  if (options.diagnostics)
    write_diagnostics(details_of(found, read_samples(folder / "samples.csv"), fit.result.fit.law.law,
                                 options.restitution.config.gravity_mps2, rate_hz),
                      folder / "diagnostics.json", run);

  const std::string summary = analyze_json({samples.result, found.recordings, clock.seconds(), warnings});
  write_text(run, folder / "summary.json", summary + "\n", {folder / "fit.json"});
  const Outcome shown = run_report({folder, folder / "report.html", title_of(found.recordings)}, run);
  const std::string answer = answer_text(fit.result.words.answer);  // first of all; the text of the fit begins with it
  // recordings that were left out are named also where the fit of the others fails
  const std::string both = detected.error.empty() || fit.outcome.error.empty() ? "" : "; ";
  return {std::max(detected.exit_code, fit.outcome.exit_code), summary,
          answer + detected.text + samples.outcome.text + fit.outcome.text.substr(answer.size()) + shown.text, warnings,
          detected.error + both + fit.outcome.error};
}

}  // namespace bouncelab::cli
