// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "command.hpp"
#include "commands/ball_choice.hpp"

namespace bouncelab::cli {

/// What `synthesize` and `loop` let the user choose of the sound. Texts are read by synthesis_config().
struct SynthesizeOptions {
  synthesis::SynthesisConfig config;
  BallChoice world = kPaperBall;
  std::string sensor = "piezo";
  std::string bits = "24";
  std::string positions = "simulated";
  std::vector<std::string> channels;  ///< X,Y[,Z[,GAIN]]
  std::string hard_case;

  std::string impacts;     ///< table to read
  std::string out;         ///< sound to write
  std::string truth;       ///< default: out with .truth.csv
  bool each_drop = false;  ///< one file for each drop
};
/// All but the files, the ball and disturbances.
const Description& members_of(const SynthesizeOptions*);

/// The recording that the options describe. @throws InvalidArgument
synthesis::SynthesisConfig synthesis_config(const SynthesizeOptions& options, const CommonOptions& common);

/// Reads options.impacts, writes options.out, the truth, and OUT.others.csv where there are sounds of other things.
Outcome run_synthesize(const SynthesizeOptions& options, const Run& run);

}  // namespace bouncelab::cli
