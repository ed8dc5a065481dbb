// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/analyze_command.hpp"
#include "options/commands.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

Command add_analyze_command(CLI::App& app) {
  auto options = std::make_shared<AnalyzeOptions>();
  CLI::App* command = app.add_subcommand(
      "analyze", "Recordings -> impact times -> eps(v) -> constants and a report; nothing has to be set");
  command->add_option("recordings", options->detect.recordings, "Recordings: WAV, FLAC, OGG, MP3, AIFF ...")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Folder for onsets, samples, fit and report")->required();
  command->add_flag("--diagnostics", options->diagnostics,
                    "Details of each drop in the report: sound and marks, intervals, learned waveform, noise");
  add_detect_options(*command, options->detect);
  add_restitution_options(*command, options->restitution);
  add_fit_options(*command, options->fit);
  command->footer("Example: bouncelab analyze drop.wav --out out/drop");
  return {command, [options](Run& run) { return run_analyze(*options, run); }};
}

}  // namespace bouncelab::cli
