// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/analyze_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "commands/report_command.hpp"
#include "files/table_file.hpp"
#include "files/wave_file.hpp"
#include "stages.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"onsets.csv",       "samples.csv",  "fit.json",   "wave.json",
                                "diagnostics.json", "summary.json", "report.html"};

std::string title_of(const std::vector<std::string>& recordings) {
  const std::string first = fs::path(recordings.front()).filename().string();
  return recordings.size() == 1 ? "Restitution from " + first
                                : fmt::format("Restitution from {} and {} more", first, recordings.size() - 1);
}

/// The report shows the sound of the first recording in which impacts were found.
void write_wave_of_first(const Run& run, const Json& recordings, const fs::path& onsets_file, const fs::path& out) {
  for (const Json& recording : recordings) {
    if (recording["n_onsets"].get<std::size_t>() == 0) continue;
    const Onsets onsets = onsets_from_table(read_table(onsets_file, onset_columns()), onsets_file.string());
    write_wave(run, recording["recording"].get<std::string>(), recording["channel"].get<int>(), onsets, out);
    return;
  }
}

/// The law of fit.json as a law; absent where the fit found none.
std::optional<RestitutionLaw> fitted_law(const Json& fit) {
  SeriesLaw law;
  law.a.assign(11, 0.0);
  for (const Json& name : fit["law"]["parameters"]) {
    if (name.get<std::string>().front() != 'A') return std::nullopt;
    const Json& value = fit["law"][name.get<std::string>()]["value"];
    if (!value.is_number()) return std::nullopt;
    law.a.at(std::stoul(name.get<std::string>().substr(1))) = value.get<double>();
  }
  if (fit["law"]["parameters"].empty()) return std::nullopt;
  return law;
}

}  // namespace

Outcome run_analyze(const AnalyzeOptions& options, Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  for (const char* name : kOutputs) check_may_write(run, folder / name);
  StageClock clock;
  std::vector<std::string> warnings;

  DetectOptions detect = options.detect;
  detect.out = folder / "onsets.csv";
  std::vector<detection::Detection> found;
  const Outcome heard = clock.time("detect", [&] { return run_detect(detect, run, &found); });
  if (found.empty()) return heard;
  add_warnings(warnings, heard.warnings);

  RestitutionOptions restitution = options.restitution;
  restitution.onsets = detect.out;
  restitution.out = folder / "samples.csv";
  const Outcome intervals = clock.time("restitution", [&] { return run_restitution(restitution, run); });
  add_warnings(warnings, intervals.warnings);

  FitOptions fit = options.fit;
  fit.samples = restitution.out;
  fit.out = folder / "fit.json";
  const Outcome fitted = clock.time("fit", [&] { return as_stage(run_fit(fit, run)); });
  add_warnings(warnings, fitted.warnings);

  const Json& recordings = heard.summary["recordings"];
  write_wave_of_first(run, recordings, detect.out, folder / "wave.json");

  // the report shows what lies in the folder: a look inside an earlier run must not stay in it
  for (const char* old : {"diagnostics.json", "diagnostics.json.meta.json"}) fs::remove(folder / old);
  if (options.diagnostics)
    write_diagnostics(run, detect.recordings, found, samples_from_table(read_table(restitution.out, sample_columns())),
                      fitted_law(fitted.summary), restitution.config.gravity_mps2, folder / "diagnostics.json");

  Json summary = intervals.summary;  // counts of onsets, drops and samples, median eps
  summary["recordings"] = recordings;
  summary["seconds"] = Json::object();
  for (const auto& [stage, seconds] : clock.seconds()) summary["seconds"][stage] = seconds;
  summary["warnings"] = warnings;
  write_text(run, folder / "summary.json", summary.dump(2) + "\n", {fit.out});

  ReportOptions report{folder, folder / "report.html", title_of(detect.recordings)};
  const Outcome shown = run_report(report, run);
  const Outcome& worst = fitted.exit_code != kDone ? fitted : heard;
  return {worst.exit_code, summary, heard.text + intervals.text + fitted.text + shown.text, warnings, worst.trouble};
}

Command add_analyze_command(CLI::App& app) {
  auto options = std::make_shared<AnalyzeOptions>();
  CLI::App* command = app.add_subcommand(
      "analyze", "Recordings -> impact times -> eps(v) -> constants and a report; nothing has to be set");
  command->add_option("recordings", options->detect.recordings, "Recordings: WAV, FLAC, OGG, MP3, AIFF ...")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Folder for onsets, samples, fit and report")->required();
  command->add_flag("--diagnostics", options->diagnostics,
                    "A look inside each drop in the report: sound and marks, intervals, learned wave, noise");
  add_detect_options(*command, options->detect);
  add_restitution_options(*command, options->restitution);
  add_fit_options(*command, options->fit);
  command->footer("Example: bouncelab analyze drop.wav --out out/drop");
  return {command, [options](Run& run) { return run_analyze(*options, run); }};
}

}  // namespace bouncelab::cli
