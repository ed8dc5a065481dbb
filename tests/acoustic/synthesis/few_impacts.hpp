// SPDX-License-Identifier: GPL-3.0-or-later
/// What the tests of the synthesis have in common: a few impacts, and a recording of nothing else.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/core/impacts.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"

namespace bouncelab::synthesis {

inline Impact impact(std::int64_t drop, std::int64_t number, double t_s, double v_mps) {
  return {drop, number, t_s, v_mps, 0.98 * v_mps, 0.98, v_mps, 0.98, -1};
}

inline Impacts impacts(const std::vector<double>& times_s, double v_mps = 1.0) {
  Impacts result;
  for (std::size_t k = 0; k < times_s.size(); ++k)
    result.rows.push_back(impact(0, static_cast<std::int64_t>(k), times_s[k], v_mps));
  return result;
}

/// A short recording of the ball alone: noise at -200 dB.
inline SynthesisConfig quiet() {
  SynthesisConfig config;
  config.snr_db = 200.0;
  config.lead_in_s = 0.1;
  config.pause_s = 0.3;
  config.start_spread_m = 0.0;
  return config;
}

inline double rms(std::span<const double> x) {
  double sum = 0.0;
  for (const double v : x) sum += v * v;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

}  // namespace bouncelab::synthesis
