// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"
#include "command.hpp"

namespace bouncelab::cli {

/// What `simulate` and `loop` let the user choose of the simulation. Texts are read by simulation_config().
struct SimulateOptions {
  sim::SimulationConfig config;
  std::int64_t n_asperities = 1'000'000;
  std::string radius_law = "uniform:5e-4,1.5e-3";
  std::string restitution_law = "series:A2=0.0467,A4=0.1339,A5=-0.2876";
  std::string contact = "paper";
  double beta = 1.0;
  double mu = 0.2;
  bool drag = false;
  std::vector<double> height_m{0.09, 0.10};
  std::vector<double> plate_m, start_m, velocity_mps, spin_radps;
  std::string surface_file;

  std::string out;  ///< of the impacts
  std::string write_surface;
  std::string preset;
};

/// Registers the physics, without files of output.
void add_simulate_options(CLI::App& app, SimulateOptions& options);

/// The experiment that the options describe. @throws InvalidArgument
sim::SimulationConfig simulation_config(const SimulateOptions& options, const CommonOptions& common);

/// The paper's run, where the user did not say otherwise: 2,320 drops of 95 bounces are 220,400 impacts.
void apply_paper_preset(const CLI::App& app, SimulateOptions& options, Run& run);

/// The ball's asperities, drawn or read. @throws InvalidArgument, FileError
sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config,
                        const ProgressCallback& progress);

/// Simulates and writes options.out (and options.write_surface where named).
Outcome run_simulate(const SimulateOptions& options, Run& run);

Command add_simulate_command(CLI::App& app);

}  // namespace bouncelab::cli
