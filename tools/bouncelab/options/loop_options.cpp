// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>

#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/loop_score.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

void apply_loop_preset(const CLI::App& app, LoopOptions& options, Run& run) {
  if (options.preset != "paper") return;
  apply_paper_preset(app, options.simulate, run);
  const auto set = [&](const std::string& name, double& value, double to) {
    if (app.get_option("--" + name)->count() > 0) return;
    value = to;
    set_parameter(run.parameters, name, fmt::format("{:g}", to));
  };
  set("lead-in", options.synthesize.config.lead_in_s, loop::kPaperLeadIn_s);
  set("pause", options.synthesize.config.pause_s, loop::kPaperPause_s);
}

void add_loop_options(CLI::App& command, LoopOptions& options) {
  command
      .add_option("--preset", options.preset,
                  "quick: 40 drops of the paper's ball, 96 kHz, noise at 30 dB, every stage on files.\n"
                  "paper: 2,320 drops of 95 impacts, through memory")
      ->check(CLI::IsMember({"quick", "paper"}));
  command.add_option("--out", options.out, "Folder for every file of the run")->type_name("FOLDER")->required();
  command.add_flag("--keep-sound", options.keep_sound, "paper: keep the sound too, DIR/sound/*.flac, 3 MB a drop");
  command.add_flag("--no-memory", options.without_memory,
                   "paper: without the fits with memory, which take three quarters of the time");
  add_ball_options(command, options.world);
  add_simulate_options(command, options.simulate);
  add_synthesize_options(command, options.synthesize);
}

namespace {

ParsedLoop parse_loop(const std::vector<std::string>& arguments) {
  ParsedLoop parsed;
  Run run;
  CLI::App app("", "loop");
  set_option_defaults(app);
  add_loop_options(app, parsed.options);
  add_common_options(app, parsed.common);
  try {
    app.parse(std::vector<std::string>{arguments.rbegin(), arguments.rend()});
  } catch (const CLI::ParseError& error) {
    throw InvalidArgument(error.what());
  }
  run.parameters = resolved_parameters(app);
  apply_loop_preset(app, parsed.options, run);
  return parsed;
}

}  // namespace

Command add_loop_command(CLI::App& app) {
  auto options = std::make_shared<LoopOptions>();
  CLI::App* command = app.add_subcommand(
      "loop",
      "The closed loop: simulate -> synthesize -> detect -> restitution -> fit -> report, all results in one folder");
  command->footer(
      "Examples: bouncelab loop --preset quick --out out/loop\n"
      "          bouncelab loop --preset paper --out out/paper\n"
      "          bouncelab loop --config samples/sweep.toml --out out/sweep   (lists in the file are run through)");
  add_loop_options(*command, *options);
  return {command, [options, command](Run& run) {
            apply_loop_preset(*command, *options, run);
            return run.sweep.empty() ? run_loop(*options, run) : run_sweep(*options, run, parse_loop);
          }};
}

}  // namespace bouncelab::cli
