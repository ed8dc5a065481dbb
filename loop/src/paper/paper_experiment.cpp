// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/paper_experiment.hpp"

#include <algorithm>

namespace bouncelab::loop {
namespace {

SlopePair pair_of(const fit::Estimate& simulation, const fit::Estimate& sound) {
  return {simulation, sound, sound.value / simulation.value};
}

}  // namespace

PaperResult paper_result(const LoopResult& loop) {
  PaperResult result;
  const fit::FitResult* smooth = loop.smooth.drops.empty() ? nullptr : &loop.smooth_sound;
  result.conclusions = fit::paper_conclusions(loop.sound, smooth, loop.simulation.law);
  const std::size_t n = std::min(loop.sound.histograms.size(), loop.direct.histograms.size());
  for (std::size_t k = 0; k < n; ++k) {
    const fit::HistogramFit &direct = loop.direct.histograms[k], &sound = loop.sound.histograms[k];
    if (!direct.slope_rising || !sound.slope_rising || !direct.slope_falling || !sound.slope_falling) continue;
    result.slopes.push_back({sound.v_mps, direct.n, sound.n, pair_of(*direct.slope_rising, *sound.slope_rising),
                             pair_of(*direct.slope_falling, *sound.slope_falling)});
  }
  return result;
}

}  // namespace bouncelab::loop
