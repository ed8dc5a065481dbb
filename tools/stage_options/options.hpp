// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::options {

/// The ball and what it falls on, as the user describes them.
struct BallChoice {
  std::string ball;   ///< for ball_from_text; empty: not named
  std::string plate;  ///< for plate_from_text; empty: not named
};

/// Options --ball and --plate.
Description members_of(const BallChoice*);
/// @param unnamed  what is taken where they are not given; empty: the default says it
Section ball_section(BallChoice& choice, std::string_view unnamed = {}, std::vector<std::string> stages = {});

/// The ball that is simulated where none is named: the paper's, on its glass plate.
inline const BallChoice kPaperBall{"steel:6mm", "glass"};

inline std::optional<Ball> ball_of(const BallChoice& choice) {
  return choice.ball.empty() ? std::nullopt : std::optional(ball_from_text(choice.ball));
}
inline std::optional<Material> plate_of(const BallChoice& choice) {
  return choice.plate.empty() ? std::nullopt : std::optional(plate_from_text(choice.plate));
}

/// All balls, materials and plates.
Object catalogue();

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

/// What the user says of a file of times or marks that this program did not write.
struct ForeignFileOptions {
  ForeignOptions table;
  std::string tier;       ///< of a TextGrid, layer of an .svl; empty: the one that looks most like impacts
  bool renumber = false;  ///< marks: number the impacts of each drop anew
  std::string recording;  ///< that marks belong to; empty: as they say
};
/// Without the last two, which are options of convert alone.
Description members_of(const ForeignFileOptions*);

struct RestitutionOptions {
  std::vector<std::string> onsets;  ///< files
  std::string out;
  ForeignFileOptions foreign;  ///< of onsets that this program did not write
  fit::RestitutionConfig config;
  BallChoice world;  ///< where a part is not named, that of `config`
};

/// With the ball and the plate that were chosen.
fit::RestitutionConfig with_ball(const RestitutionOptions& options);

/// What `synthesize` and `loop` let the user choose of the sound. Texts are read by synthesis_config().
struct SynthesizeOptions {
  synthesis::SynthesisConfig config;
  BallChoice world = kPaperBall;
  std::string sensor = "piezo";
  std::string bits = "24";
  std::string positions = "simulated";
  std::vector<std::string> channels;                             ///< X,Y[,Z[,GAIN]]
  std::optional<double> reverberation_db, reverberation_time_s;  ///< of a microphone's room, instead of the preset's
  std::string hard_case = "none";

  std::string impacts;         ///< table to read
  std::string out;             ///< sound to write
  std::string truth;           ///< default: out with .truth.csv
  bool each_drop = false;      ///< one file for each drop
  std::string codec = "none";  ///< NAME:KBITS through which the sound goes
};
/// All but the files, the ball and disturbances.
Description members_of(const SynthesizeOptions*);
Section disturbances_section(SynthesizeOptions& options);

/// @param bits  16, 24, 32 or float
audio::SampleEncoding encoding_of(const std::string& bits);

/// The recording that the options describe. @throws InvalidArgument
synthesis::SynthesisConfig synthesis_config(const SynthesizeOptions& options, std::uint64_t seed, int n_threads);

}  // namespace bouncelab::options
