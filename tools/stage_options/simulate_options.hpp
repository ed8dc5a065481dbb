// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/sim/experiment.hpp"
#include "stage_options/ball_choice.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::options {

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
Description members_of(const SimulateOptions*);

/// What only a simulation of its own has: first drop, preset, states.
Section simulation_alone_section(SimulateOptions& options);

/// The experiment that the options describe. @throws InvalidArgument
sim::SimulationConfig simulation_config(const SimulateOptions& options, std::uint64_t seed, int n_threads);

}  // namespace bouncelab::options
