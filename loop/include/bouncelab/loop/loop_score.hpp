// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/detection/score.hpp"
#include "bouncelab/fit/fit.hpp"

namespace bouncelab::loop {

/// One quantity, measured twice: from the true impact times and from those detected in the sound.
struct Compared {
  std::optional<fit::Estimate> from_true_times, from_sound;
};

struct ComparedNode {
  double v_mps = 0.0;
  double truth = 0.0;  ///< eps(v) of the law simulated
  Compared eps;
  Compared eps_with_memory;  ///< absent where there was no fit with memory
};

struct ComparedConstant {
  std::string name;             ///< A2, A4, A5
  std::optional<double> truth;  ///< absent where the law simulated is no series
  Compared value;
};

struct ComparedSlopes {
  double v_mps = 0.0;
  Compared rising, falling;
};

struct LawPoint {
  double v_mps = 0.0;
  double eps = 0.0;
};

/// What went into a closed loop beside what came out of it.
struct LoopScore {
  std::size_t n_drops = 0;
  std::size_t n_samples = 0;                ///< used by the fit to the sound
  detection::OnsetScore onsets;             ///< detected against true times
  std::vector<ComparedNode> nodes;          ///< at the nodes of the fit to the sound
  std::vector<ComparedConstant> constants;  ///< A2, A4, A5
  std::vector<ComparedSlopes> slopes;       ///< of p(eps) at 0.3, 0.6 and 1 m/s
  std::vector<LawPoint> truth_curve;        ///< the law simulated at the speeds of the curve fitted to the sound
};

/// @param onsets      detected against true times, of all drops
/// @param truth       the law simulated
/// @param true_times  fitted to the true times
/// @param sound       fitted to the detected times
LoopScore score_loop(std::size_t n_drops, const detection::OnsetScore& onsets, const RestitutionLaw& truth,
                     const fit::FitResult& true_times, const fit::FitResult& sound);

}  // namespace bouncelab::loop
