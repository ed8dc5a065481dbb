// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/commands.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>

#include "options/common_options.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {
namespace {

/// @param with_ball  the stage is about the ball on the plate, which `command` adds once for all
template <class Options>
std::vector<std::string> names_of(void (*add)(CLI::App&, Options&), bool with_ball = false) {
  CLI::App app;
  Options options;
  add(app, options);
  std::vector<std::string> names = config_keys(app);
  if (with_ball) names.insert(names.end(), {"ball", "plate"});
  return names;
}

/// The options of a stage that `command` hands on to it; absent where it does not run the stage.
std::optional<std::vector<std::string>> handed_on(const std::string& command, const std::string& stage) {
  if (command == "loop") {
    if (stage == "simulate") return names_of(add_simulate_options, true);
    if (stage == "synthesize") return names_of(add_synthesize_options, true);
    if (stage == "detect" || stage == "restitution" || stage == "fit" || stage == "report")
      return std::vector<std::string>{};
  }
  if (command == "analyze") {
    if (stage == "detect") return names_of(add_detect_options);
    if (stage == "restitution") return names_of(add_restitution_options, true);
    if (stage == "fit") return names_of(add_fit_options, true);
    if (stage == "report") return std::vector<std::string>{};
  }
  return std::nullopt;
}

}  // namespace

// in the order of --help; stages in that of the data
const std::vector<CommandName>& all_commands() {
  static const std::string whole = "From recording, or simulation, to the answer", stages = "Step by step",
                           beside = "Beside them";
  static const std::vector<CommandName> all{
      {"analyze", add_analyze_command, whole},
      {"loop", add_loop_command, whole},
      {"simulate", add_simulate_command, stages},
      {"synthesize", add_synthesize_command, stages},
      {"detect", add_detect_command, stages},
      {"restitution", add_restitution_command, stages},
      {"fit", add_fit_command, stages},
      {"roughness", add_roughness_command, stages},
      {"compare", add_compare_command, stages},
      {"report", add_report_command, stages},
      {"convert", add_convert_command, beside},
      {"balls", add_balls_command, beside},
      {"calibrate", add_calibrate_command, beside},
      {"completion", add_completion_command, beside},
  };
  return all;
}

std::optional<ConfigSection> config_section(const std::string& command, const std::string& section) {
  const auto named = std::find_if(all_commands().begin(), all_commands().end(),
                                  [&](const CommandName& c) { return c.name == section; });
  if (named == all_commands().end()) return std::nullopt;
  CLI::App app;
  CommonOptions common;
  const Command added = named->add(app);
  add_common_options(*added.app, common);
  const std::vector<std::string> known = config_keys(*added.app);
  return ConfigSection{known, section == command ? known : handed_on(command, section)};
}

}  // namespace bouncelab::cli
