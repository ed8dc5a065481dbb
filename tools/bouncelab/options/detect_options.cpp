// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/detect_command.hpp"
#include "options/commands.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void add_detect_options(CLI::App& app, DetectOptions& options) {
  app.add_option("--channel", options.channel, "Channel, from 0; -1 = the one in which impacts are detected best")
      ->check(within(-1, 1023));
  app.add_option("--min-impacts", options.min_impacts, "Drops of fewer impacts are left out")
      ->check(within(3, 1000000));
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
  return {command, [options](Run& run) { return run_detect(*options, run).outcome; }};
}

}  // namespace bouncelab::cli
