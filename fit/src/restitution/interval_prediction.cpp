// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/interval_prediction.hpp"

namespace bouncelab::fit {

std::vector<IntervalPrediction> predict_intervals(const RestitutionSamples& samples, const std::string& recording,
                                                  std::int64_t drop, const std::optional<RestitutionLaw>& law,
                                                  double gravity_mps2) {
  std::vector<IntervalPrediction> intervals;
  for (const RestitutionSample& s : samples) {
    if (s.recording != recording || s.drop != drop) continue;
    const double before_s = 2.0 * s.v_mps / gravity_mps2;
    IntervalPrediction interval{s.impact, s.eps * before_s, std::nullopt, std::nullopt};
    if (law) interval.predicted_s = restitution(*law, s.v_mps) * before_s;
    if (s.sigma_eps) interval.sigma_s = *s.sigma_eps * before_s;
    intervals.push_back(interval);
  }
  return intervals;
}

}  // namespace bouncelab::fit
