// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "bouncelab/loop/loop_score.hpp"
#include "commands/loop_command.hpp"
#include "options/commands.hpp"
#include "options/parser.hpp"

namespace bouncelab::cli {

std::vector<Section> loop_sections(LoopOptions& options) {
  using O = LoopOptions;
  static const Description own{
      member("preset", &O::preset,
             "quick: 40 drops of the paper's ball, 96 kHz, noise at 30 dB, every stage on files.\n"
             "paper: 2,320 drops of 95 impacts, through memory")
          .one_of({"quick", "paper"}),
      member("out", &O::out, "Folder for every file of the run").looks_like("FOLDER").required(),
      member("keep_sound", &O::keep_sound, "paper: keep the sound too, DIR/sound/*.flac, 3 MB a drop"),
      member("no_memory", &O::without_memory,
             "paper: without the fits with memory, which take three quarters of the time")};
  static const Description ball = ball_options("");
  Section disturbances = disturbances_section(options.synthesize);
  disturbances.stages = {"synthesize"};
  return {{"", &own, &options},
          {"", &ball, &options.world, {"simulate", "synthesize"}},
          {"Ball, ground and drops", &members_of(&options.simulate), &options.simulate, {"simulate"}},
          {"Sound", &members_of(&options.synthesize), &options.synthesize, {"synthesize"}},
          disturbances};
}

void apply_loop_preset(LoopOptions& options, Run& run) {
  if (options.preset != "paper") return;
  apply_paper_preset(options.simulate, run);
  const auto set = [&](const std::string& name, double& value, double to) {
    if (run.given.contains(name)) return;
    value = to;
    set_parameter(run.parameters, name, fmt::format("{:g}", to));
  };
  set("lead-in", options.synthesize.config.lead_in_s, loop::kPaperLeadIn_s);
  set("pause", options.synthesize.config.pause_s, loop::kPaperPause_s);
}

ParsedLoop parse_loop(const std::vector<std::string>& arguments) {
  ParsedLoop parsed;
  Run run;
  std::vector<Section> sections = loop_sections(parsed.options);
  sections.push_back(common_section(parsed.common));
  try {
    run.given = set_options(sections, arguments);
  } catch (const WrongUsage& error) {
    throw InvalidArgument(error.what());
  }
  apply_loop_preset(parsed.options, run);
  return parsed;
}

Command loop_command() {
  auto options = std::make_shared<LoopOptions>();
  return {
      "loop",
      "The closed loop: simulate -> synthesize -> detect -> restitution -> fit -> report, all results in one folder",
      "Examples: bouncelab loop --preset quick --out out/loop\n"
      "          bouncelab loop --preset paper --out out/paper\n"
      "          bouncelab loop --config samples/sweep.toml --out out/sweep   (lists in the file are run through)",
      loop_sections(*options),
      [options](Run& run) {
        apply_loop_preset(*options, run);
        return run.sweep.empty() ? run_loop(*options, run) : run_sweep(*options, run);
      },
      {"simulate", "synthesize", "detect", "restitution", "fit", "report"}};
}

}  // namespace bouncelab::cli
