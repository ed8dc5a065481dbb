// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/commands.hpp"

namespace bouncelab::cli {

// in the order of --help; stages in that of the data
const std::vector<CommandName>& all_commands() {
  static const std::string whole = "From recording, or simulation, to the answer", stages = "Step by step",
                           beside = "Beside them";
  static const std::vector<CommandName> all{
      {"analyze", analyze_command, whole},
      {"loop", loop_command, whole},
      {"simulate", simulate_command, stages},
      {"synthesize", synthesize_command, stages},
      {"detect", detect_command, stages},
      {"restitution", restitution_command, stages},
      {"fit", fit_command, stages},
      {"roughness", roughness_command, stages},
      {"compare", compare_command, stages},
      {"report", report_command, stages},
      {"dem", dem_command, stages},
      {"convert", convert_command, beside},
      {"validate", validate_command, beside},
      {"balls", balls_command, beside},
      {"calibrate", calibrate_command, beside},
      {"completion", completion_command, beside},
  };
  return all;
}

}  // namespace bouncelab::cli
