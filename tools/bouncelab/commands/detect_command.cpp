// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/detect_command.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

constexpr std::size_t kMostLines =
    20;  // for people: of thousands of recordings those in which nothing was found, and a sum

/// At most kMostLines of the lines and how many more there are.
std::vector<std::string> first_of(std::vector<std::string> lines, const char* where_all_are) {
  if (lines.size() <= kMostLines) return lines;
  const std::size_t n_more = lines.size() - kMostLines;
  lines.resize(kMostLines);
  lines.push_back(fmt::format("... and {} more; {}", n_more, where_all_are));
  return lines;
}

/// One line a recording, for people.
std::string describe(const std::string& recording, const detection::Detection& d) {
  std::string line = fmt::format("{}: {}", recording, d.message);
  if (d.summary.restitution_median) line += fmt::format(", eps = {:.4f} in the median", *d.summary.restitution_median);
  if (d.summary.n_channels > 1) line += fmt::format("; channel {} ({})", d.summary.channel, d.summary.channel_reason);
  return line;
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

/// What went wrong with the recordings as a whole: exit code and error of the outcome.
void conclude(const std::vector<std::string>& recordings, const std::vector<detection::Detection>& found,
              std::size_t n_onsets, Outcome& outcome) {
  const auto is_unreadable = [](const detection::Detection& d) {
    return d.status == detection::DetectionStatus::unreadable;
  };
  const auto n_unreadable = std::count_if(found.begin(), found.end(), is_unreadable);
  const std::size_t n_others = found.size() - 1;
  const std::string others = n_others > 0 ? fmt::format(" (nor in the {} others)", n_others) : "";
  if (n_unreadable > 0) {
    const detection::Detection& first = *std::find_if(found.begin(), found.end(), is_unreadable);
    outcome.exit_code = kFileError;
    outcome.error =
        n_unreadable == 1 ? first.message : fmt::format("{} (and {} more)", first.message, n_unreadable - 1);
  }
  if (n_onsets == 0) {
    if (n_unreadable < std::ssize(found)) {
      const auto readable = std::find_if_not(found.begin(), found.end(), is_unreadable);
      outcome.exit_code = kNotUsable;
      outcome.error =
          fmt::format("{}: {}{}; no onsets were written. Listen to it: is this the recording, and the channel?",
                      recordings[static_cast<std::size_t>(readable - found.begin())], readable->message, others);
    }
    outcome.text.clear();
  } else if (n_unreadable > 0) {
    outcome.error += fmt::format("; the results are those of the {} recordings that could be read",
                                 std::ssize(found) - n_unreadable);
  }
}

/// What was found in each recording, in the order given; files are read in parallel.
std::vector<detection::Detection> detect_all(const DetectOptions& options, const Run& run) {
  detection::DetectionConfig config;
  if (options.channel >= 0) config.channel = options.channel;
  const std::vector<std::filesystem::path> recordings(options.recordings.begin(), options.recordings.end());
  return detection::detect(recordings, config, run.common.n_threads,
                           progress_line(run, "detect", recordings.size() == 1 ? "s of sound" : "recordings"));
}

}  // namespace

Stage<std::vector<detection::Detection>> run_detect(const DetectOptions& options, const Run& run) {
  check_may_write(run, options.out);
  if (!options.labels.empty()) {
    if (options.recordings.size() > 1)
      throw InvalidArgument("--labels: a label track belongs to one recording; give one");
    check_may_write(run, options.labels);
  }
  Stage<std::vector<detection::Detection>> stage;
  stage.result = detect_all(options, run);
  const std::vector<detection::Detection>& found = stage.result;
  Outcome& outcome = stage.outcome;
  std::vector<std::filesystem::path> inputs;
  Onsets joined;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found.size() > 1) joined.insert(joined.end(), found[k].onsets.begin(), found[k].onsets.end());
    if (found[k].status != detection::DetectionStatus::unreadable) inputs.emplace_back(options.recordings[k]);
  }
  const Onsets& all = found.size() == 1 ? found.front().onsets : joined;  // ten hours are 60 MB
  outcome.text = describe_all(options.recordings, found);
  outcome.warnings = warnings_of(options.recordings, found);
  outcome.json = detect_json(options.recordings, found);
  conclude(options.recordings, found, all.size(), outcome);
  if (all.empty()) return stage;
  write_table(run, options.out, to_table(all), inputs);
  if (!options.labels.empty())
    write_text(run, options.labels, audio::audacity_labels(audio::annotations_of(all)), inputs);
  return stage;
}

}  // namespace bouncelab::cli
