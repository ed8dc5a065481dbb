// SPDX-License-Identifier: GPL-3.0-or-later
#include "detect_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "bouncelab/acoustic/marks.hpp"
#include "bouncelab/core/error.hpp"
#include "progress_line.hpp"
#include "table_file.hpp"

namespace bouncelab::cli {
namespace {

const char* word(DetectionStatus status) {
  switch (status) {
    case DetectionStatus::ok:
      return "ok";
    case DetectionStatus::too_few_impacts:
      return "too_few_impacts";
    case DetectionStatus::silent:
      return "silent";
  }
  return "?";
}

}  // namespace

void add_detect_options(CLI::App& app, DetectOptions& options) {
  app.add_option("--channel", options.channel, "Channel, from 0; -1 = the one in which impacts are heard best")
      ->check(CLI::Range(-1, 1023));
}

std::vector<Detection> detect_all(const DetectOptions& options, const Run& run) {
  DetectionConfig config;
  if (options.channel >= 0) config.channel = options.channel;
  const std::vector<std::filesystem::path> recordings(options.recordings.begin(), options.recordings.end());
  return detect(recordings, config, run.common.n_threads,
                progress_line(run, "detect", recordings.size() == 1 ? "s of sound" : "recordings"));
}

std::string describe(const std::string& recording, const Detection& d) {
  std::string line = fmt::format("{}: {}", recording, d.message);
  if (d.summary.restitution_median) line += fmt::format(", eps = {:.4f} in the median", *d.summary.restitution_median);
  if (d.summary.n_channels > 1) line += fmt::format("; channel {} ({})", d.summary.channel, d.summary.channel_reason);
  return line;
}

Json to_json(const std::string& recording, const Detection& d) {
  const RecordingSummary& s = d.summary;
  return {{"recording", recording},
          {"status", word(d.status)},
          {"message", d.message},
          {"n_onsets", d.onsets.size()},
          {"n_drops", s.n_drops},
          {"n_candidates", s.n_candidates},
          {"rate_hz", s.rate_hz},
          {"n_channels", s.n_channels},
          {"channel", s.channel},
          {"channel_reason", s.channel_reason},
          {"duration_s", s.duration_s},
          {"noise_rms", s.noise_rms},
          {"eps_median", s.restitution_median ? Json(*s.restitution_median) : Json(nullptr)},
          {"warnings", d.warnings}};
}

Outcome run_detect(const DetectOptions& options, Run& run, std::vector<Detection>* keep) {
  check_may_write(run, options.out);
  if (!options.labels.empty()) {
    if (options.recordings.size() > 1)
      throw InvalidArgument("--labels: a label track belongs to one recording; give one");
    check_may_write(run, options.labels);
  }
  Outcome outcome;
  Onsets all;
  Json recordings = Json::array();
  std::vector<Detection> found = detect_all(options, run);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const std::string& recording = options.recordings[k];
    all.insert(all.end(), found[k].onsets.begin(), found[k].onsets.end());
    outcome.text += describe(recording, found[k]) + "\n";
    for (const std::string& warning : found[k].warnings) outcome.warnings.push_back(recording + ": " + warning);
    recordings.push_back(to_json(recording, found[k]));
  }
  outcome.summary = {{"n_onsets", all.size()}, {"recordings", recordings}};
  if (all.empty()) {
    outcome.exit_code = kNotUsable;
    outcome.trouble =
        fmt::format("{}: {}{}; no onsets were written. Listen to it: is this the recording, and the channel?",
                    options.recordings.front(), found.front().message,
                    found.size() > 1 ? fmt::format(" (nor in the {} others)", found.size() - 1) : "");
    outcome.text.clear();
    return outcome;
  }
  const std::vector<std::filesystem::path> inputs(options.recordings.begin(), options.recordings.end());
  write_table(run, options.out, to_table(all), inputs);
  if (!options.labels.empty()) write_text(run, options.labels, audacity_labels(marks_of(all)), inputs);
  if (keep != nullptr) *keep = std::move(found);
  return outcome;
}

Command add_detect_command(CLI::App& app) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App* command =
      app.add_subcommand("detect",
                         "Impact times of bouncing balls in recordings, with standard errors; nothing has to be set\n"
                         "Example: bouncelab detect drop.wav --out onsets.csv --labels drop.txt");
  command->add_option("recordings", options->recordings, "Recordings: WAV, FLAC, OGG, MP3, AIFF ...")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Onsets, .csv")->required();
  command->add_option("--labels", options->labels, "Also an Audacity label track");
  add_detect_options(*command, *options);
  return {command, [options](Run& run) { return run_detect(*options, run); }};
}

}  // namespace bouncelab::cli
