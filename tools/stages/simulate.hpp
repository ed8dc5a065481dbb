// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"
#include "stage_options/options.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// The number of drops and impacts of the paper's run, where the user did not set them.
void apply_paper_preset(SimulateOptions& options, Run& run);

/// The asperities of the file that the options name; absent where they name none. @throws FileError
std::optional<sim::Surface> surface_from_file(const SimulateOptions& options, const Ball& ball);

/// The asperities of that file, else those drawn. @throws FileError
sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config, const Run& run);

/// The files that a simulation reads: surface, table of the law.
std::vector<std::filesystem::path> simulation_inputs(const SimulateOptions& options);

/// What --json prints.
Object summary_of(const sim::SimulationResult& result, const Ball& ball);

/// Simulates and writes options.out (and options.write_surface where named).
Outcome run_simulate(const SimulateOptions& options, const Run& run);

/// Option --codec, which needs files.
Section codec_section(SynthesizeOptions& options, std::vector<std::string> stages = {});

/// What is simulated and made sound of, by one choice of ball and plate.
struct Scene {
  BallChoice world = kPaperBall;  ///< of both stages, in place of their own
  SimulateOptions simulate;
  SynthesizeOptions synthesize;
};
/// Ball, drops, sound and disturbances.
std::vector<Section> scene_sections(Scene& scene, bool with_codec = false);
/// One combination of the values that a configuration file lists: of a scene, or of the seed.
/// @throws InvalidArgument naming the option
void set_scene(Scene& scene, CommonOptions& common, const loop::Settings& settings);

/// Reads options.impacts, writes options.out, the truth, and OUT.others.csv where there are sounds of other things.
Outcome run_synthesize(const SynthesizeOptions& options, const Run& run);

}  // namespace bouncelab::stages
