// SPDX-License-Identifier: GPL-3.0-or-later
/// Options of the stages that `loop` and `analyze` share with the commands of their own: the physics, without files.
#pragma once

#include "commands/detect_command.hpp"
#include "commands/fit_command.hpp"
#include "commands/restitution_command.hpp"
#include "commands/simulate_command.hpp"
#include "commands/synthesize_command.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

void add_simulate_options(CLI::App& app, SimulateOptions& options);
void add_synthesize_options(CLI::App& app, SynthesizeOptions& options);
void add_detect_options(CLI::App& app, DetectOptions& options);
void add_restitution_options(CLI::App& app, RestitutionOptions& options);
void add_fit_options(CLI::App& app, FitOptions& options);

/// The number of drops and impacts of the paper's run, where the user did not set them.
void apply_paper_preset(const CLI::App& app, SimulateOptions& options, Run& run);

}  // namespace bouncelab::cli
