// SPDX-License-Identifier: GPL-3.0-or-later
#include "synthetic_samples.hpp"

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_with_memory.hpp"

namespace bouncelab::testing {
namespace {

double scatter_of(const SyntheticRun& run, double v_mps, Random& random) {
  const double below = mean_below(run, v_mps), above = mean_above(run, v_mps);
  switch (run.scatter) {
    case Scatter::asymmetric_laplace:
      return random.uniform() < above / (above + below) ? above * random.exponential() : -below * random.exponential();
    case Scatter::normal:
      return above * random.normal();
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

RestitutionSamples rough_drops(const RoughDrops& drops, std::uint64_t seed) {
  const RestitutionLaw law = SeriesLaw{};
  RestitutionSamples samples;
  for (int drop = 0; drop < drops.n; ++drop) {
    Random random(seed, RandomStream::test, static_cast<std::uint64_t>(drop));
    const double differs = drops.spread > 0.0 ? 1.0 + drops.spread * random.normal() : 1.0;
    const auto eps = [&](double v) { return 1.0 - differs * (1.0 - restitution(law, v)); };
    double v = 1.4 * std::sqrt(random.uniform(0.9, 1.0)), w = 0.0, mean_w = 0.0;
    if (drops.release > 0.0) w = drops.release * (drops.same ? 1.0 : random.exponential());
    std::vector<double> times{0.0};
    for (int k = 0; k < drops.impacts + 2; ++k) {
      if (!drops.memory) w = mean_w * random.exponential();
      mean_w += 2.0 * drops.q * (1.0 + eps(v)) * (1.0 + eps(v)) * v * v;
      const double z2 = random.normal(), z1 = random.normal();
      v *= restitution_with_memory(v, eps, drops.q * std::pow(v, drops.power), z1, z2, w);
      w *= drops.kept * (1.0 - drops.slips * std::pow(0.7, k));
      times.push_back(times.back() + 2.0 * v / 9.81);
    }
    for (double& t : times) t += drops.timing_s * random.normal();
    for (std::size_t k = 1; k + 1 < times.size(); ++k) {
      RestitutionSample s;
      const double before = times[k] - times[k - 1], after = times[k + 1] - times[k];
      s.drop = drop;
      s.impact = static_cast<std::int64_t>(k);
      s.t_s = times[k];
      s.v_mps = 0.5 * 9.81 * before;
      s.eps = after / before;
      if (drops.timing_s > 0.0) {
        s.sigma_v_mps = 0.5 * 9.81 * drops.timing_s * std::sqrt(2.0);
        s.sigma_eps = drops.timing_s * std::sqrt(1.0 + (1.0 + s.eps) * (1.0 + s.eps) + s.eps * s.eps) / before;
      }
      s.conditions.gravity_mps2 = 9.81;
      s.conditions.ball = Ball{1e-6};  // contacts of the drawn drops have no height
      samples.push_back(s);
    }
  }
  return samples;
}

}  // namespace bouncelab::testing
