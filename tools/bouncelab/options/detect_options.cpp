// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/detect_command.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void add_detect_options(CLI::App& app, DetectOptions& options) {
  app.option_defaults()->group("Detection");
  app.add_option("--channel", options.channel, "Channel, from 0; -1 = the one in which impacts are detected best")
      ->check(within(-1, 1023));
  app.add_option("--rate", options.rate_hz,
                 "Sampling rate [Hz] of numbers (.npy, .csv) that come without times; 0 = none")
      ->check(within(0.0, 4e6));
  app.add_option("--min-impacts", options.min_impacts, "Drops of fewer impacts are left out")
      ->check(within(3, 1000000));
}

Command add_detect_command(CLI::App& app) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App* command = app.add_subcommand(
      "detect", "Impact times of bouncing balls in recordings, with standard errors; nothing has to be set");
  command->footer("Example: bouncelab detect drop.wav --out onsets.csv --labels drop.txt");
  command
      ->add_option(
          "recordings", options->recordings,
          "Recordings: WAV, FLAC, MP3 ...; m4a, mp4 and others by ffmpeg; .npy, .csv of samples; - = standard input")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--list", options->list, "File with more recordings, one a line")->type_name("FILE");
  command->add_option("--out", options->out, "Onsets, .csv")->type_name("FILE")->required();
  command->add_option("--labels", options->labels, "Also an Audacity label track")->type_name("FILE");
  add_detect_options(*command, *options);
  return {command, [options](Run& run) { return run_detect(*options, run).outcome; }};
}

}  // namespace bouncelab::cli
