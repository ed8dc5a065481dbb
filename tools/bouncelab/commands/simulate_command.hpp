// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/sim/energy.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"
#include "command.hpp"
#include "commands/ball_choice.hpp"

namespace bouncelab::cli {

/// What `simulate` and `loop` let the user choose of the simulation. Texts are read by simulation_config().
struct SimulateOptions {
  sim::SimulationConfig config;
  BallChoice world = kPaperBall;
  std::int64_t n_asperities = 1'000'000;
  std::string radius_law = "uniform:5e-4,1.5e-3";
  std::string restitution_law = "series:A2=0.0467,A4=0.1339,A5=-0.2876";
  std::string contact = "paper";
  double beta = 1.0;
  double mu = 0.2;
  bool drag = false;
  bool contact_patch = false;
  std::vector<double> height_m{0.09, 0.10};
  std::vector<double> start_m{0.0, 0.0}, velocity_mps{0.0, 0.0}, spin_radps{0.0, 0.0, 0.0};
  std::vector<double> plate_m;  ///< empty: no edge
  std::string surface_file;

  std::string out;  ///< of the impacts
  std::string write_surface;
  std::string preset;
};
/// All but the files and the ball.
const Description& members_of(const SimulateOptions*);
/// The number of drops and impacts of the paper's run, where the user did not set them.
void apply_paper_preset(SimulateOptions& options, Run& run);

/// The experiment that the options describe. @throws InvalidArgument
sim::SimulationConfig simulation_config(const SimulateOptions& options, const CommonOptions& common);

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

}  // namespace bouncelab::cli
