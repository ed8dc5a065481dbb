// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::report {

inline constexpr double kG = kDefaultGravity_mps2;

/// A ball dropped from a height, by exact flights under drag kappa v^2; contacts take no time.
struct Drop {
  double height_m = 0.0;
  std::function<double(int)> eps = [](int) { return 0.9; };  ///< of each impact
  std::size_t n_impacts = 20;
  double begin_s = 2.0;  ///< of the fall
  double kappa_per_m = 0.0;
  std::int64_t number = 0;
};

/// The inverse of flight_with_drag, and the fall: time down from a height is (v_t/g) atanh(w/v_t).
inline Onsets onsets_of(const Drop& drop) {
  const double kappa = std::max(1e-9, drop.kappa_per_m), limit_mps = std::sqrt(kG / kappa);
  double v_mps = fall_with_drag_mps(drop.height_m, kG, kappa);
  double t_s = drop.begin_s + limit_mps / kG * std::atanh(v_mps / limit_mps);
  Onsets onsets;
  for (std::size_t k = 0; k < drop.n_impacts; ++k) {
    Onset onset;
    onset.recording = "ball.wav";
    onset.drop = drop.number;
    onset.impact = static_cast<std::int64_t>(k);
    onset.t_s = t_s;
    onset.sigma_t_s = 1e-6;
    onsets.push_back(onset);
    const double x = drop.eps(static_cast<int>(k)) * v_mps / limit_mps;
    t_s += limit_mps / kG * (std::atan(x) + std::asinh(x));
    v_mps = limit_mps * x / std::sqrt(1.0 + x * x);
  }
  return onsets;
}

inline fit::RestitutionConfig no_air() {
  fit::RestitutionConfig config;
  config.air_kgpm3 = 0.0;
  config.instant_contacts = true;
  return config;
}

/// Of a ball in no air, whose contacts take no time.
inline RestitutionSamples samples_of(const Drop& drop) {
  return fit::restitution_samples(onsets_of(drop), no_air()).samples;
}

}  // namespace bouncelab::report
