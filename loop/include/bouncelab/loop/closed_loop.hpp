// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/loop/detector_score.hpp"
#include "bouncelab/loop/theory.hpp"
#include "bouncelab/sim/contact.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::loop {

/// Of whoever does not want to see the progress.
inline ProgressCallback no_progress(const std::string&, const std::string&) { return {}; }

/// One recording, of a drop or of all: its true impact times and those detected in its sound.
struct RecordingResult {
  std::string recording;  ///< its name in tables
  std::vector<synthesis::TrueImpact> truth;
  std::vector<synthesis::OtherSound> others;  ///< of one recording of all drops
  Onsets onsets;
  double sound_s = 0.0;  ///< length of the recording
};

/// The detected onsets, one recording after the other.
Onsets onsets_of(const std::vector<RecordingResult>& recordings);
/// The truth with all its columns.
Table truth_table_of(const std::vector<RecordingResult>& recordings);

/// Speeds at which truth and results are compared [m/s]: slow, middle and fast impacts of a drop from 10 cm.
inline constexpr std::array kNodeSpeeds_mps{0.25, 0.6, 1.2};

/// The closed loop: simulate -> synthesize -> detect -> restitution -> fit. Defaults: 40 drops of the paper's ball on
/// glass, recorded at 96 kHz with a signal-to-noise ratio of 30 dB.
struct LoopConfig {
  sim::SimulationConfig simulation;
  std::int64_t n_asperities = 1'000'000;  ///< drawn with the seed of the simulation
  sim::RadiusLaw radius_law;
  std::optional<sim::Surface> surface;  ///< given: instead of drawing asperities
  synthesis::SynthesisConfig synthesis;
  /// All drops in this one recording, which is replaced: its template is learned of all. Absent: a recording of one
  /// channel for each drop, through memory, in parallel.
  std::optional<std::filesystem::path> recording;
  bool with_smooth_ball = false;  ///< also the same ball without asperities, kRoughDropsPerSmoothDrop times fewer
  bool with_direct = true;        ///< also the fit to the simulation itself, without any measurement
  bool with_memory = false;       ///< also the fit with memory, to the true and to the detected times
  /// The recordings of the drops are kept in this folder, which must exist, as rough.0017.flac; files there are
  /// replaced. Absent: they are not kept.
  std::optional<std::filesystem::path> sound_folder;
  int n_threads = 0;  ///< 0: all cores; results do not depend on it
};

/// One smooth drop for so many rough ones: the scatter left of a smooth ball is that of the method itself.
constexpr std::int64_t kRoughDropsPerSmoothDrop = 20;

/// One ball: simulated, synthesized, detected.
struct BallResult {
  std::string name;  ///< "rough" or "smooth"
  Impacts impacts;   ///< with states where the configuration asks for them
  std::vector<RecordingResult> recordings;
  DetectorScore score;  ///< of all recordings
};

struct LoopResult {
  sim::SimulationConfig simulation;
  BallResult rough;
  sim::BallSection section;                ///< of the rough ball
  std::vector<sim::EnergyShares> shares;   ///< of the rough ball
  std::vector<sim::Reservoir> reservoirs;  ///< of the rough ball, after each impact
  BallResult smooth;                       ///< without recordings where it was not asked for
  RestitutionSamples samples_direct;       ///< eq. 12 of the paper: macroscopic eps of the simulation, no sound
  RestitutionSamples samples_true;         ///< eq. 2 of the paper from the true times
  RestitutionSamples samples_sound;        ///< eq. 2 of the paper from the detected times
  RestitutionSamples samples_smooth;       ///< likewise, of the smooth ball
  fit::FitResult direct, true_times, sound, smooth_sound;
  std::optional<ScatterTheory> theory;      ///< of the rough ball, in the windows of `sound`
  std::optional<ReservoirCheck> reservoir;  ///< of the rough ball, from its sound
};

/// Runs the loop with all data in memory but for the one recording.
/// @throws InvalidArgument naming the setting that is out of range, FileError (disk full), what `progress` throws
LoopResult run_loop(const LoopConfig& config, const StageProgress& progress = no_progress);

/// Length of the sound of all drops [s].
double sound_s(const LoopResult& loop);

}  // namespace bouncelab::loop
