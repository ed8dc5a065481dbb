// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stage_options/simulate_options.hpp"
#include "stage_options/synthesize_options.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// Ball, drops, sound and disturbances of a run that simulates and synthesizes.
std::vector<Section> scene_sections(BallChoice& world, SimulateOptions& simulate, SynthesizeOptions& synthesize);
/// Option --codec, which needs files.
Section codec_section(SynthesizeOptions& options, std::vector<std::string> stages = {});

/// Reads options.impacts, writes options.out, the truth, and OUT.others.csv where there are sounds of other things.
Outcome run_synthesize(const SynthesizeOptions& options, const Run& run);

}  // namespace bouncelab::stages
