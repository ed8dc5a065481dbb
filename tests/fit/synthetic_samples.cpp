// SPDX-License-Identifier: GPL-3.0-or-later
#include "synthetic_samples.hpp"

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab::testing {
namespace {

double scatter_of(const SyntheticRun& run, double v_mps, Random& random) {
  const double below = mean_below(run, v_mps), above = mean_above(run, v_mps);
  switch (run.scatter) {
    case Scatter::asymmetric_laplace:
      return random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
    case Scatter::normal:
      return above * random.normal();
    case Scatter::gumbel:
      return above * std::log(random.exponential());
    case Scatter::student_t3: {
      double chi2 = 0.0;
      for (int i = 0; i < 3; ++i) chi2 += std::pow(random.normal(), 2);
      return above * random.normal() / std::sqrt(chi2 / 3.0);
    }
  }
  return 0.0;
}

}  // namespace

double mean_below(const SyntheticRun& run, double v_mps) { return run.below_at_1mps / v_mps; }
double mean_above(const SyntheticRun& run, double v_mps) { return run.above_at_1mps / v_mps; }

Onsets synthetic_onsets(const SyntheticRun& run) {
  Onsets onsets;
  for (std::size_t drop = 0; drop < run.n_drops; ++drop) {
    Random random(run.seed, RandomStream::test, drop);
    double v = std::sqrt(2.0 * kDefaultGravity_mps2 * random.uniform(0.09, 0.10));
    double t = v / kDefaultGravity_mps2;
    for (std::size_t k = 0; k < run.n_impacts; ++k) {
      Onset onset;
      onset.drop = static_cast<std::int64_t>(drop);
      onset.impact = static_cast<std::int64_t>(k);
      onset.t_s = t + run.timing_sigma_s * random.normal();
      onset.sigma_t_s = run.timing_sigma_s;
      onsets.push_back(onset);
      v *= restitution(run.law, v) + scatter_of(run, v, random);
      t += 2.0 * v / kDefaultGravity_mps2;
    }
  }
  return onsets;
}

RestitutionSamples independent_samples(const SyntheticRun& run, std::size_t n, double v_lo_mps, double v_hi_mps,
                                       double sigma_eps_at_1mps) {
  RestitutionSamples samples(n);
  Random random(run.seed, RandomStream::test, 0);
  for (std::size_t k = 0; k < n; ++k) {
    RestitutionSample& s = samples[k];
    s.drop = static_cast<std::int64_t>(k / 95);
    s.impact = static_cast<std::int64_t>(k % 95);
    s.v_mps = v_lo_mps * std::pow(v_hi_mps / v_lo_mps, random.uniform());
    const double sigma = sigma_eps_at_1mps / s.v_mps;
    s.eps = restitution(run.law, s.v_mps) + scatter_of(run, s.v_mps, random) + sigma * random.normal();
    if (sigma > 0.0) s.sigma_eps = sigma;
  }
  return samples;
}

}  // namespace bouncelab::testing
