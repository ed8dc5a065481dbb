// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/analyze_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/fit/interval_prediction.hpp"
#include "commands/report_command.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"
#include "json/wave_json.hpp"
#include "stage_clock.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

using Detections = std::vector<detection::Detection>;

const char* const kOutputs[] = {"onsets.csv",       "samples.csv",  "fit.json",   "wave.json",
                                "diagnostics.json", "summary.json", "report.html"};

std::string title_of(const std::vector<std::string>& recordings) {
  const std::string first = fs::path(recordings.front()).filename().string();
  return recordings.size() == 1 ? "Restitution from " + first
                                : fmt::format("Restitution from {} and {} more", first, recordings.size() - 1);
}

bool has_onsets(const detection::Detection& d) { return !d.onsets.empty(); }

/// The report shows the sound of the first recording in which impacts were found.
void write_wave_of_first(const std::vector<std::string>& recordings, const Detections& found, const fs::path& out,
                         const Run& run) {
  const auto first = std::find_if(found.begin(), found.end(), has_onsets);
  if (first == found.end()) return;
  const fs::path recording = recordings[static_cast<std::size_t>(first - found.begin())];
  write_text(run, out, wave_json(detection::wave_preview(recording, first->summary.channel, first->onsets)) + "\n",
             {recording});
}

constexpr std::int64_t kDropsShown = 30;

/// The details of the first drops of all recordings (at most kDropsShown).
std::vector<RecordingDetails> details_of(const std::vector<std::string>& recordings, const Detections& found,
                                         const RestitutionSamples& samples, const std::optional<RestitutionLaw>& law,
                                         double gravity_mps2) {
  std::vector<RecordingDetails> all;
  std::int64_t n_shown = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const detection::Detection& d = found[k];
    if (!has_onsets(d) || n_shown >= kDropsShown) continue;
    RecordingDetails details{recordings[k], d.summary.n_drops, d.wave, d.noise, {}};
    audio::AudioReader reader(recordings[k]);
    const auto sound = reader.source(d.summary.channel);
    for (std::int64_t drop = 0; drop < d.summary.n_drops && n_shown < kDropsShown; ++drop, ++n_shown)
      details.drops.push_back({detection::drop_preview(sound, recordings[k], d.summary.channel, d.onsets, drop),
                               fit::predict_intervals(samples, recordings[k], drop, law, gravity_mps2)});
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
  Stage<fit::Restitution> samples;
  Stage<fit::FitResult> fit;
};

Constants times_to_constants(const AnalyzeOptions& options, const fs::path& folder, const Run& run, StageClock& clock) {
  Constants constants;
  RestitutionOptions restitution = options.restitution;
  restitution.onsets = folder / "onsets.csv";
  restitution.out = folder / "samples.csv";
  constants.samples = clock.time("restitution", [&] { return run_restitution(restitution, run); });
  FitOptions fit = options.fit;
  fit.samples = restitution.out;
  fit.out = folder / "fit.json";
  constants.fit = clock.time("fit", [&] { return as_stage(run_fit(fit, run)); });
  return constants;
}

}  // namespace

Outcome run_analyze(const AnalyzeOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  for (const char* name : kOutputs) check_may_write(run, folder / name);
  StageClock clock;
  DetectOptions detect = options.detect;
  detect.out = folder / "onsets.csv";
  const auto [detected, found] = clock.time("detect", [&] { return run_detect(detect, run); });
  if (std::none_of(found.begin(), found.end(), has_onsets)) return detected;
  const auto [samples, fit] = times_to_constants(options, folder, run, clock);
  const std::vector<std::string> warnings =
      joined(joined(detected.warnings, samples.outcome.warnings), fit.outcome.warnings);

  write_wave_of_first(detect.recordings, found, folder / "wave.json", run);
  // the report shows what lies in the folder: details of an earlier run must not stay in it
  for (const char* old : {"diagnostics.json", "diagnostics.json.meta.json"}) fs::remove(folder / old);
  if (options.diagnostics)
    write_diagnostics(details_of(detect.recordings, found, samples.result.samples, fit.result.law.law,
                                 options.restitution.config.gravity_mps2),
                      folder / "diagnostics.json", run);

  const std::string summary =
      analyze_json({samples.result.counts, detect.recordings, found, clock.seconds(), warnings});
  write_text(run, folder / "summary.json", summary + "\n", {folder / "fit.json"});
  const Outcome shown = run_report({folder, folder / "report.html", title_of(detect.recordings)}, run);
  const Outcome& worst = fit.outcome.exit_code != kDone ? fit.outcome : detected;
  return {worst.exit_code, summary, detected.text + samples.outcome.text + fit.outcome.text + shown.text, warnings,
          worst.error};
}

}  // namespace bouncelab::cli
