// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/loop/detector_score.hpp"

namespace bouncelab::loop {

struct LoopResult;

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
Description members_of(const ComparedNode*);

struct ComparedConstant {
  std::string name;             ///< A2, A4, A5
  std::optional<double> truth;  ///< absent where the law simulated is no series
  Compared value;
};
Description members_of(const ComparedConstant*);

struct ComparedSlopes {
  double v_mps = 0.0;
  Compared rising, falling;
};
Description members_of(const ComparedSlopes*);

struct LawPoint {
  double v_mps = 0.0;
  double eps = 0.0;
};
Description members_of(const LawPoint*);

/// What went into a closed loop beside what came out of it.
struct LoopScore {
  std::size_t n_drops = 0;
  std::size_t n_samples = 0;                ///< used by the fit to the sound
  DetectorScore onsets;                     ///< detected against true times
  std::vector<ComparedNode> nodes;          ///< at the nodes of the fit to the sound
  std::vector<ComparedConstant> constants;  ///< A2, A4, A5
  std::vector<ComparedSlopes> slopes;       ///< of p(eps) at 0.3, 0.6 and 1 m/s
  std::vector<LawPoint> truth_curve;        ///< the law simulated at the speeds of the curve fitted to the sound
};
Description members_of(const LoopScore*);

/// @param onsets      detected against true times, of all drops
/// @param truth       the law simulated
/// @param true_times  fitted to the true times
/// @param sound       fitted to the detected times
LoopScore score_loop(std::size_t n_drops, const DetectorScore& onsets, const RestitutionLaw& truth,
                     const fit::FitResult& true_times, const fit::FitResult& sound);

// The experiment of Montaine et al., doi:10.1103/PhysRevE.84.041306: 2,320 drops of 95 bounces are 220,400 impacts.
constexpr std::int64_t kPaperDrops = 2320;
constexpr std::int64_t kPaperImpacts = 95;
// Recordings that begin and end close to the drop: 6.9 hours in all.
constexpr double kPaperLeadIn_s = 0.1;
constexpr double kPaperPause_s = 0.3;

/// A slope of p(eps), from the simulation itself and from its sound.
struct SlopePair {
  fit::Estimate simulation, sound;
};
/// {simulation, sound, ratio}, the ratio of the sound over the simulation
Value as_value(const SlopePair& pair);

struct SlopeWindow {
  double v_mps = 0.0;
  std::size_t n_simulation = 0, n_sound = 0;  ///< samples
  SlopePair rising, falling;
};
Description members_of(const SlopeWindow*);

/// Windows of speed in which simulation and sound have both slopes.
std::vector<SlopeWindow> slopes_of(const LoopResult& loop);

// Parts of a FitResult; absent, or null, where it does not have them. Speeds agree to within 1e-9 m/s.
std::optional<fit::Estimate> eps_at(const fit::FitResult& fit, double v_mps);
const fit::HistogramFit* window_at(const fit::FitResult& fit, double v_mps);
std::optional<fit::Estimate> slope_at(const fit::FitResult& fit, double v_mps,
                                      std::optional<fit::Estimate> fit::HistogramFit::*side);
std::optional<fit::Estimate> parameter_named(const fit::FitResult& fit, std::string_view name);

}  // namespace bouncelab::loop
