// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/fit/conclusions.hpp"
#include "bouncelab/loop/closed_loop.hpp"

namespace bouncelab::loop {

// The experiment of Montaine et al., doi:10.1103/PhysRevE.84.041306: 2,320 drops of 95 bounces are 220,400 impacts.
constexpr std::int64_t kPaperDrops = 2320;
constexpr std::int64_t kPaperImpacts = 95;
// Recordings that begin and end close to the drop: 6.9 hours in all.
constexpr double kPaperLeadIn_s = 0.1;
constexpr double kPaperPause_s = 0.3;

/// A slope of p(eps), from the simulation itself and from its sound.
struct SlopePair {
  fit::Estimate simulation, sound;
  double ratio = 1.0;  ///< sound over simulation
};

struct SlopeWindow {
  double v_mps = 0.0;
  std::size_t n_simulation = 0, n_sound = 0;  ///< samples
  SlopePair rising, falling;
};

/// What the experiment says of the paper's conclusions.
struct PaperResult {
  std::vector<fit::Conclusion> conclusions;
  std::vector<SlopeWindow> slopes;  ///< windows of speed in which both have both slopes
};

/// @param loop  with the smooth ball; without it, the conclusion about it is left out
PaperResult paper_result(const LoopResult& loop);

}  // namespace bouncelab::loop
