// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/parallel.hpp"
#include "commands/analyze_command.hpp"
#include "files.hpp"
#include "files/json_lines_table.hpp"
#include "files/label_track.hpp"
#include "files/table_file.hpp"
#include "json/json_text.hpp"
#include "options.hpp"

namespace bouncelab::web {
namespace {

using Json = nlohmann::ordered_json;

const char* const kOut = "out";  // folder of the results

Json rows_of(const Table& table) {
  std::stringstream lines;
  cli::write_json_lines(lines, table);
  Json rows = Json::array();
  for (std::string line; std::getline(lines, line);) rows.push_back(Json::parse(line));
  return rows;
}

/// Options of `analyze`.
struct AnalyzeCall {
  cli::AnalyzeOptions options;
  cli::Run run;

  AnalyzeCall(const Sound& sound, const std::string& options_json) {
    using O = cli::AnalyzeOptions;
    static const Description own{member("diagnostics", &O::diagnostics, "Details of each drop in the report"),
                                 member<O>(
                                     "lossy_coding", [](auto& o) -> auto& { return o.detect.config.lossy_coding; },
                                     "Coding of the samples that the browser has decoded")};
    static const Description ball = cli::ball_options("");
    run = parse({{"", &own, &options},
                 {"", &members_of(&options.detect.config), &options.detect.config},
                 {"", &ball, &options.restitution.world},
                 {"", &members_of(&options.restitution), &options.restitution},
                 {"", &members_of(&options.fit.config), &options.fit.config}},
                options_json);
    options.out = kOut;
    options.detect.recordings = {file_name(sound.name)};
    write_sound(options.detect.recordings.front(), sound);
  }
};

/// What the command left in its folder. @throws InvalidArgument where that is not even a report
Analysis results(const cli::Outcome& outcome, const cli::Run& run) {
  const std::filesystem::path folder = kOut;
  Analysis found{read_file(folder / "summary.json"),
                 read_file(folder / "onsets.csv"),
                 read_file(folder / "samples.csv"),
                 read_file(folder / "fit.json"),
                 read_file(folder / "wave.json"),
                 read_file(folder / "report.html"),
                 ""};
  if (found.report_html.empty())
    throw InvalidArgument(outcome.error.empty() ? "no result for the recording" : outcome.error);
  const Onsets onsets = onsets_from_table(cli::read_table(folder / "onsets.csv", onset_columns()), "onsets.csv");
  cli::write_label_track(run, "labels.txt", onsets, {});
  found.labels = read_file("labels.txt");
  return found;
}

/// Onsets of the sound as if they had been detected.
cli::Stage<cli::DetectResult> as_detected(const Onsets& onsets, const Sound& sound, const cli::DetectOptions& options) {
  detection::Detection found;
  found.onsets = onsets;
  found.status = detection::DetectionStatus::ok;
  found.message = std::to_string(onsets.size()) + " impacts as marked";
  found.summary.lossy_coding = options.config.lossy_coding;
  found.summary.rate_hz = sound.rate_hz;
  found.summary.n_channels = sound.n_channels;
  found.summary.channel = std::clamp(options.config.channel.value_or(0), 0, sound.n_channels - 1);
  found.summary.channel_reason = "as marked";
  found.summary.duration_s =
      static_cast<double>(sound.samples.size()) / static_cast<double>(sound.n_channels) / sound.rate_hz;
  std::set<std::int64_t> drops;
  for (const Onset& onset : onsets) drops.insert(onset.drop);
  found.summary.n_drops = std::ssize(drops);
  cli::Stage<cli::DetectResult> stage;
  if (!options.config.lossy_coding.empty()) {
    found.warnings.push_back(detection::lossy_coding_warning(options.config.lossy_coding));
    stage.outcome.warnings.push_back(options.recordings.front() + ": " + found.warnings.back());
  }
  stage.result.recordings.push_back({options.recordings.front(), found.status, found.message, found.summary,
                                     found.drops, found.warnings, onsets.size()});
  stage.result.first.emplace(0, std::move(found));
  return stage;
}

}  // namespace

std::string detect(const Sound& sound, const std::string& options_json) {
  const WorkingFolder folder;
  AnalyzeCall call(sound, options_json);
  call.options.detect.out = "onsets.csv";
  cli::Stage<cli::DetectResult> stage;
  with_threads(1, [&] { stage = cli::run_detect(call.options.detect, call.run); });
  const cli::Outcome& outcome = stage.outcome;
  Json json = Json::parse(outcome.error.empty() ? outcome.json
                                                : cli::with_error(outcome.json, outcome.error, outcome.exit_code));
  const bool any = !stage.result.first.empty();
  json["onsets"] = any ? rows_of(to_table(stage.result.first.begin()->second.onsets)) : Json::array();
  return cli::json_text(json);
}

Analysis analyze(const Sound& sound, const std::string& options_json) {
  const WorkingFolder folder;
  const AnalyzeCall call(sound, options_json);
  cli::Outcome outcome;
  with_threads(1, [&] { outcome = cli::run_analyze(call.options, call.run); });
  return results(outcome, call.run);
}

Analysis analyze_onsets(const std::string& onsets_csv, const Sound& sound, const std::string& options_json) {
  const WorkingFolder folder;
  const AnalyzeCall call(sound, options_json);
  write_file("marks.csv", onsets_csv);
  Onsets onsets = onsets_from_table(cli::read_table("marks.csv", onset_columns()), "marks.csv");
  if (onsets.empty()) throw InvalidArgument("no impact is marked; mark at least three");
  for (Onset& onset : onsets) onset.recording = call.options.detect.recordings.front();
  std::filesystem::create_directories(kOut);
  cli::write_table(call.run, std::filesystem::path(kOut) / "onsets.csv", to_table(onsets));
  cli::Outcome outcome;
  cli::StageClock clock;
  with_threads(1, [&] {
    outcome = cli::analyze_found(call.options, as_detected(onsets, sound, call.options.detect), call.run, clock);
  });
  return results(outcome, call.run);
}

}  // namespace bouncelab::web
