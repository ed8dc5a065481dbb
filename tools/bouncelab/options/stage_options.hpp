// SPDX-License-Identifier: GPL-3.0-or-later
/// Options of the stages that `loop` and `analyze`, the page and the Python module share with the commands of their
/// own: the physics, without files, and, but for add_simulation_options, without the ball, which they add once for all
/// stages (ball_options.hpp).
#pragma once

#include "commands/calibrate_command.hpp"
#include "commands/detect_command.hpp"
#include "commands/fit_command.hpp"
#include "commands/loop_command.hpp"
#include "commands/restitution_command.hpp"
#include "commands/roughness_command.hpp"
#include "commands/simulate_command.hpp"
#include "commands/synthesize_command.hpp"

namespace CLI {
class App;
}

namespace bouncelab::cli {

void add_simulate_options(CLI::App& app, SimulateOptions& options);
/// The same, and what only a simulation of its own has: first drop, preset, states. `preset` is to be applied by
/// apply_paper_preset.
void add_simulation_options(CLI::App& app, SimulateOptions& options);
void add_synthesize_options(CLI::App& app, SynthesizeOptions& options);
void add_detect_options(CLI::App& app, DetectOptions& options);
void add_restitution_options(CLI::App& app, RestitutionOptions& options);
void add_fit_options(CLI::App& app, FitOptions& options);
void add_roughness_options(CLI::App& app, RoughnessOptions& options);
/// All but the file.
void add_calibrate_options(CLI::App& app, CalibrateOptions& options);

/// With the folder and the ball.
void add_loop_options(CLI::App& app, LoopOptions& options);

/// The paper's run, where the user did not choose otherwise.
void apply_loop_preset(const CLI::App& app, LoopOptions& options, Run& run);
/// The number of drops and impacts of the paper's run, where the user did not set them.
void apply_paper_preset(const CLI::App& app, SimulateOptions& options, Run& run);

}  // namespace bouncelab::cli
