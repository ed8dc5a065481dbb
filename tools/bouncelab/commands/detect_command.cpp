// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/detect_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "files/table_file.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

const char* word(detection::DetectionStatus status) {
  switch (status) {
    case detection::DetectionStatus::ok:
      return "ok";
    case detection::DetectionStatus::too_few_impacts:
      return "too_few_impacts";
    case detection::DetectionStatus::silent:
      return "silent";
    case detection::DetectionStatus::unreadable:
      return "unreadable";
  }
  return "?";
}

constexpr std::size_t kMostLines = 20;  // for people: of thousands of recordings those with trouble, and a sum

/// At most kMostLines of the lines and how many more there are.
std::vector<std::string> first_of(std::vector<std::string> lines, const char* where_all_are) {
  if (lines.size() <= kMostLines) return lines;
  const std::size_t n_more = lines.size() - kMostLines;
  lines.resize(kMostLines);
  lines.push_back(fmt::format("... and {} more; {}", n_more, where_all_are));
  return lines;
}

std::vector<std::string> warnings_of(const std::vector<std::string>& recordings,
                                     const std::vector<detection::Detection>& found) {
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k].status == detection::DetectionStatus::unreadable) warnings.push_back(found[k].message + "; left out");
    for (const std::string& warning : found[k].warnings) warnings.push_back(recordings[k] + ": " + warning);
  }
  return first_of(std::move(warnings), "with --json all of them are listed");
}

/// A line a recording; of very many a sum, and a line for each in which nothing was found.
std::string describe_all(const std::vector<std::string>& recordings, const std::vector<detection::Detection>& found) {
  std::vector<std::string> lines;
  std::size_t n_onsets = 0;
  std::int64_t n_drops = 0;
  const bool many = found.size() > kMostLines;
  for (std::size_t k = 0; k < found.size(); ++k) {
    n_onsets += found[k].onsets.size();
    n_drops += found[k].summary.n_drops;
    if (found[k].status != detection::DetectionStatus::unreadable &&
        !(many && found[k].status == detection::DetectionStatus::ok))
      lines.push_back(describe(recordings[k], found[k]));
  }
  std::string text;
  for (const std::string& line : first_of(std::move(lines), "with --json all of them are listed")) text += line + "\n";
  if (many) text += fmt::format("{} impacts in {} drops in {} recordings\n", n_onsets, n_drops, found.size());
  return text;
}

/// What went wrong with the recordings as a whole; exit code and trouble of the outcome.
void conclude(const std::vector<std::string>& recordings, const std::vector<detection::Detection>& found,
              Outcome& outcome) {
  const auto is_unreadable = [](const detection::Detection& d) {
    return d.status == detection::DetectionStatus::unreadable;
  };
  const auto n_unreadable = std::count_if(found.begin(), found.end(), is_unreadable);
  const std::size_t n_others = found.size() - 1;
  const std::string others = n_others > 0 ? fmt::format(" (nor in the {} others)", n_others) : "";
  if (n_unreadable > 0) {
    const detection::Detection& first = *std::find_if(found.begin(), found.end(), is_unreadable);
    outcome.exit_code = kFileTrouble;
    outcome.trouble =
        n_unreadable == 1 ? first.message : fmt::format("{} (and {} more)", first.message, n_unreadable - 1);
  }
  if (outcome.summary["n_onsets"] == 0) {
    if (n_unreadable < std::ssize(found)) {
      const auto heard = std::find_if_not(found.begin(), found.end(), is_unreadable);
      outcome.exit_code = kNotUsable;
      outcome.trouble =
          fmt::format("{}: {}{}; no onsets were written. Listen to it: is this the recording, and the channel?",
                      recordings[static_cast<std::size_t>(heard - found.begin())], heard->message, others);
    }
    outcome.text.clear();
  } else if (n_unreadable > 0) {
    outcome.trouble += fmt::format("; the results are those of the {} recordings that could be read",
                                   std::ssize(found) - n_unreadable);
  }
}

}  // namespace

void add_detect_options(CLI::App& app, DetectOptions& options) {
  app.add_option("--channel", options.channel, "Channel, from 0; -1 = the one in which impacts are heard best")
      ->check(CLI::Range(-1, 1023));
}

std::vector<detection::Detection> detect_all(const DetectOptions& options, const Run& run) {
  detection::DetectionConfig config;
  if (options.channel >= 0) config.channel = options.channel;
  const std::vector<std::filesystem::path> recordings(options.recordings.begin(), options.recordings.end());
  return detection::detect(recordings, config, run.common.n_threads,
                           progress_line(run, "detect", recordings.size() == 1 ? "s of sound" : "recordings"));
}

std::string describe(const std::string& recording, const detection::Detection& d) {
  std::string line = fmt::format("{}: {}", recording, d.message);
  if (d.summary.restitution_median) line += fmt::format(", eps = {:.4f} in the median", *d.summary.restitution_median);
  if (d.summary.n_channels > 1) line += fmt::format("; channel {} ({})", d.summary.channel, d.summary.channel_reason);
  return line;
}

Json to_json(const std::string& recording, const detection::Detection& d) {
  const detection::RecordingSummary& s = d.summary;
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
          {"contact_time_at_1_mps_s", s.contact_time_at_1_mps_s ? Json(*s.contact_time_at_1_mps_s) : Json(nullptr)},
          {"contact_time_sigma_s", s.contact_time_sigma_s ? Json(*s.contact_time_sigma_s) : Json(nullptr)},
          {"warnings", d.warnings}};
}

Outcome run_detect(const DetectOptions& options, Run& run, std::vector<detection::Detection>* keep) {
  check_may_write(run, options.out);
  if (!options.labels.empty()) {
    if (options.recordings.size() > 1)
      throw InvalidArgument("--labels: a label track belongs to one recording; give one");
    check_may_write(run, options.labels);
  }
  Outcome outcome;
  Json recordings = Json::array();
  std::vector<std::filesystem::path> inputs;
  std::vector<detection::Detection> found = detect_all(options, run);
  Onsets joined;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found.size() > 1) joined.insert(joined.end(), found[k].onsets.begin(), found[k].onsets.end());
    recordings.push_back(to_json(options.recordings[k], found[k]));
    if (found[k].status != detection::DetectionStatus::unreadable) inputs.emplace_back(options.recordings[k]);
  }
  const Onsets& all = found.size() == 1 ? found.front().onsets : joined;  // ten hours are 60 MB
  outcome.text = describe_all(options.recordings, found);
  outcome.warnings = warnings_of(options.recordings, found);
  outcome.summary = {{"n_onsets", all.size()}, {"recordings", recordings}};
  conclude(options.recordings, found, outcome);
  if (all.empty()) return outcome;
  write_table(run, options.out, to_table(all), inputs);
  if (!options.labels.empty())
    write_text(run, options.labels, audio::audacity_labels(audio::annotations_of(all)), inputs);
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
