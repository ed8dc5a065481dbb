// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "stage_options/ball_choice.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::options {

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

/// The recording that the options describe. @throws InvalidArgument
synthesis::SynthesisConfig synthesis_config(const SynthesizeOptions& options, std::uint64_t seed, int n_threads);

}  // namespace bouncelab::options
