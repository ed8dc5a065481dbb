// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "commands/analyze_command.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {
namespace {

/// out/drop.m4a -> out/drop-bouncelab
std::string folder_beside(const std::string& recording) {
  if (recording == "-") return "standard-input-bouncelab";
  const std::filesystem::path path = recording;
  return (path.parent_path() / (path.stem().string() + "-bouncelab")).string();
}

}  // namespace

Command add_analyze_command(CLI::App& app) {
  auto options = std::make_shared<AnalyzeOptions>();
  CLI::App* command = app.add_subcommand(
      "analyze", "Recordings -> impact times -> eps(v) -> constants and a report; nothing has to be set");
  command
      ->add_option(
          "recordings", options->detect.recordings,
          "Recordings: WAV, FLAC, MP3 ...; m4a, mp4 and others by ffmpeg; .npy, .csv of samples; - = standard input")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--list", options->detect.list, "File with more recordings, one a line")->type_name("FILE");
  CLI::Option* out = command->add_option(
      "--out", options->out,
      "Folder for onsets, samples, fit and report (default: beside the first recording, its name + -bouncelab)");
  out->type_name("FOLDER");
  command->add_flag("--diagnostics", options->diagnostics,
                    "Details of each drop in the report: sound and marks, intervals, learned waveform, noise");
  add_detect_options(*command, options->detect);
  add_ball_options(*command, options->restitution.world, "not known, so that drag and contact time stay open");
  add_restitution_options(*command, options->restitution);
  add_fit_options(*command, options->fit);
  command->footer("Example: bouncelab analyze drop.wav --out out/drop");
  return {command, [options](Run& run) {
            if (options->out.empty()) {
              options->out = folder_beside(recordings_of(options->detect).front().string());
              set_parameter(run.parameters, "out", options->out);
            }
            return run_analyze(*options, run);
          }};
}

}  // namespace bouncelab::cli
