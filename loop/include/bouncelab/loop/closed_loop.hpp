// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/detection/score.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/loop/drops.hpp"
#include "bouncelab/loop/reservoir_check.hpp"
#include "bouncelab/loop/scatter_theory.hpp"
#include "bouncelab/sim/contact.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::loop {

/// The closed loop: simulate -> synthesize -> detect -> restitution -> fit. Defaults: 40 drops of the paper's ball on
/// glass, recorded at 96 kHz with a signal-to-noise ratio of 30 dB.
struct LoopConfig {
  sim::SimulationConfig simulation;
  std::int64_t n_asperities = 1'000'000;  ///< drawn with the seed of the simulation
  sim::RadiusLaw radius_law;
  std::optional<sim::Surface> surface;   ///< given: instead of drawing asperities
  synthesis::SynthesisConfig synthesis;  ///< one channel
  bool with_smooth_ball = false;  ///< also the same ball without asperities, kRoughDropsPerSmoothDrop times fewer
  bool with_memory = false;       ///< also the fit with memory, to the true and to the detected times
  std::optional<std::filesystem::path> sound_folder;  ///< as DropRecording::folder
  /// Speeds at which truth and results are compared [m/s]: slow, middle and fast impacts of a drop from 10 cm.
  std::vector<double> node_speeds_mps{0.25, 0.6, 1.2};
  int n_threads = 0;  ///< 0: all cores; results do not depend on it
};

/// One smooth drop for so many rough ones: the scatter left of a smooth ball is that of the method itself.
constexpr std::int64_t kRoughDropsPerSmoothDrop = 20;

/// One ball: simulated, synthesized, detected.
struct BallResult {
  std::string name;  ///< "rough" or "smooth"
  Impacts impacts;   ///< without states
  std::vector<DropResult> drops;
  detection::OnsetScore score;
};

struct LoopResult {
  sim::SimulationConfig simulation;
  BallResult rough;
  sim::BallSection section;                ///< of the rough ball
  std::vector<sim::EnergyShares> shares;   ///< of the rough ball
  sim::EnergyLedger energy;                ///< of the rough ball
  std::vector<sim::Reservoir> reservoirs;  ///< of the rough ball, after each impact
  BallResult smooth;                       ///< without drops where it was not asked for
  RestitutionSamples samples_direct;       ///< eq. 12 of the paper: macroscopic eps of the simulation, no sound
  RestitutionSamples samples_true;         ///< eq. 2 of the paper from the true times
  RestitutionSamples samples_sound;        ///< eq. 2 of the paper from the detected times
  RestitutionSamples samples_smooth;       ///< likewise, of the smooth ball
  fit::FitResult direct, true_times, sound, smooth_sound;
  std::optional<ScatterTheory> theory;                              ///< of the rough ball, in the windows of `sound`
  std::optional<ReservoirCheck> reservoir;                          ///< of the rough ball, from its sound
  std::vector<std::pair<std::string, double>> wall_s, processor_s;  ///< by stage, in order
};

/// Makes the progress callback of a stage: `label` is what is done ("simulate"), `unit` what is counted ("drops").
using StageProgress = std::function<ProgressCallback(const std::string& label, const std::string& unit)>;

/// Runs the loop with all data in memory.
/// @throws InvalidArgument naming the setting that is out of range, FileError (disk full), what `progress` throws
LoopResult run_loop(const LoopConfig& config, const StageProgress& progress = {});

/// How samples are made of the onsets of this experiment: its gravity, its ball.
fit::RestitutionConfig restitution_config_of(const sim::SimulationConfig& simulation);
/// Which disturbances the samples of this experiment contain: a simulated ball is struck without delay and, in the
/// sound, each drop at one point.
fit::BudgetConfig budget_config_of(const sim::SimulationConfig& simulation);

/// Length of the sound of all drops [s].
double sound_s(const LoopResult& loop);

}  // namespace bouncelab::loop
