// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/sim/contact.hpp"
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
/// That surface, else the one drawn with the configuration's seed: what `simulate` drops.
sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config,
                        const ProgressCallback& progress = {});

/// The files that a simulation reads: surface, table of the law.
std::vector<std::filesystem::path> simulation_inputs(const SimulateOptions& options);

/// What --json prints.
Object summary_of(const sim::SimulationResult& result, const Ball& ball);

/// Simulates and writes options.out (and options.write_surface where named).
/// @param reservoirs  takes those after each impact, which the table of impacts has only with states; null: not wanted
Outcome run_simulate(const SimulateOptions& options, const Run& run, std::vector<sim::Reservoir>* reservoirs = nullptr);

/// Ball, drops, sound and disturbances of a run that simulates and synthesizes.
std::vector<Section> scene_sections(BallChoice& world, SimulateOptions& simulate, SynthesizeOptions& synthesize);
/// Option --codec, which needs files.
Section codec_section(SynthesizeOptions& options, std::vector<std::string> stages = {});

/// Reads options.impacts, writes options.out, the truth, and OUT.others.csv where there are sounds of other things.
Outcome run_synthesize(const SynthesizeOptions& options, const Run& run);

}  // namespace bouncelab::stages
