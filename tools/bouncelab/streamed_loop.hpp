// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/detection/score.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/sim/energy_shares.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "command.hpp"
#include "commands/loop_command.hpp"
#include "drop_stream.hpp"
#include "run_journal.hpp"

namespace bouncelab::cli {

/// What one ball went through: simulated, sounded, heard.
struct HeardBall {
  std::string name;
  Impacts impacts;  ///< without states
  std::vector<HeardDrop> drops;
  detection::OnsetScore score;
};

/// The closed loop, drops flowing through memory.
struct StreamedLoop {
  sim::SimulationConfig simulation;
  HeardBall rough;
  std::vector<sim::EnergyShares> shares;  ///< of the rough ball
  sim::EnergyLedger energy;               ///< likewise
  HeardBall smooth;                       ///< the same ball without asperities; no drops where it was not asked for
  RestitutionSamples samples_direct;      ///< eq. 12 of the paper: macroscopic eps of the simulation, no sound
  RestitutionSamples samples_true;        ///< eq. 2 from the true times
  RestitutionSamples samples_sound;       ///< eq. 2 from the times heard
  fit::FitResult direct, true_times, sound, smooth_sound;
  std::vector<std::pair<std::string, double>> wall_s, processor_s;  ///< by stage, in order
};

/// One smooth drop for so many rough ones: what is left of the scatter of a smooth ball is the method's own.
constexpr std::int64_t kRoughDropsPerSmoothDrop = 20;

/// Drops that a journal held, by ball.
struct FinishedDrops {
  std::vector<HeardDrop> rough, smooth;
  void add(const Json& part);
};

/// Runs the loop through memory.
/// @param with_smooth  also the smooth ball
/// @param finished     drops that are heard already
/// @param journal      where finished drops are noted; null: nowhere
StreamedLoop run_streamed(const LoopOptions& options, bool with_smooth, FinishedDrops finished, RunJournal* journal,
                          Run& run);

}  // namespace bouncelab::cli
