// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_with_memory.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kGravity_mps2 = 9.81;

struct Drawn {
  std::vector<ImpactChain> chains;
  std::vector<double> gained_m2ps2;  ///< of the sampler's own reservoir
};

/// Drops by the sampler with memory, whose reservoir is known.
/// @param timing_s  standard deviation of the times
Drawn drawn_drops(double q, int n_drops, double timing_s, std::uint64_t seed) {
  const RestitutionLaw law = SeriesLaw{};
  const auto eps = [&](double v) { return restitution(law, v); };
  constexpr int kImpacts = 80;
  Drawn drawn;
  for (int drop = 0; drop < n_drops; ++drop) {
    Random random(seed, RandomStream::test, static_cast<std::uint64_t>(drop));
    double v = 1.35, w = 0.0, t_s = 0.0;
    std::vector<double> times_s{timing_s * random.normal()};
    for (int k = 0; k <= kImpacts; ++k) {
      t_s += 2.0 * v / kGravity_mps2;
      times_s.push_back(t_s + timing_s * random.normal());
      const double z2 = random.normal(), z1 = random.normal();
      if (k < kImpacts) v *= restitution_with_memory(v, eps, q, z1, z2, w);
    }
    ImpactChain chain;
    for (std::size_t k = 1; k + 1 < times_s.size(); ++k) {
      chain.v_mps.push_back(0.5 * kGravity_mps2 * (times_s[k] - times_s[k - 1]));
      chain.v_after_mps.push_back(0.5 * kGravity_mps2 * (times_s[k + 1] - times_s[k]));
    }
    chain.sigma_t_s.assign(times_s.size(), timing_s);
    drawn.chains.push_back(std::move(chain));
    drawn.gained_m2ps2.push_back(w);
  }
  return drawn;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double x : values) sum += x * x;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(ReservoirGains, AreThoseOfTheReservoirWhereSpeedsAndLawAreExact) {
  for (const double q : {2e-6, 2e-5}) {
    const Drawn drawn = drawn_drops(q, 100, 0.0, 1);
    const auto gains = reservoir_gains(drawn.chains, {SeriesLaw{}, {}, {}}, kGravity_mps2);
    std::vector<double> errors, expected;
    double sum = 0.0, path = 0.0;
    for (std::size_t k = 0; k < gains.size(); ++k) {
      errors.push_back(gains[k].gain_m2ps2 - drawn.gained_m2ps2[k]);
      expected.push_back(gains[k].offset_se_m2ps2);
      sum += gains[k].gain_m2ps2;
      path += gains[k].path_m2ps2;
      EXPECT_EQ(gains[k].timing_se_m2ps2, 0.0);
      EXPECT_FALSE(gains[k].law_se_m2ps2);
    }
    // the error stated bounds that of t^2, which scatters less where w singles out an offset; q of these drops is known
    // to a tenth (w is exponential), which moves all of them by a tenth of 1 % of w
    const double of_q = 1e-3 * root_mean_square(drawn.gained_m2ps2);
    EXPECT_LT(root_mean_square(errors), root_mean_square(expected) + of_q) << q;
    EXPECT_GT(root_mean_square(errors), 0.3 * root_mean_square(expected)) << q;
    // w of a drop from rest is exponential of mean 2 q S: of 100 drops the mean is known to a tenth, three of these
    EXPECT_NEAR(sum / path, 2.0 * q, 0.3 * 2.0 * q);
  }
}

TEST(ReservoirGains, HaveTheErrorThatTheTimesGiveThem) {
  constexpr double kTiming_s = 2e-5, kQ = 2e-6;
  const Drawn exact = drawn_drops(kQ, 200, 0.0, 2);
  Drawn noisy = drawn_drops(kQ, 200, 0.0, 2);
  std::vector<double> pulls;
  for (std::size_t d = 0; d < noisy.chains.size(); ++d) {
    Random random(3, RandomStream::test, d);
    ImpactChain& chain = noisy.chains[d];
    std::vector<double> error_s;
    for (double& sigma : chain.sigma_t_s) {
      sigma = kTiming_s;
      error_s.push_back(kTiming_s * random.normal());
    }
    for (std::size_t k = 0; k < chain.v_mps.size(); ++k) {
      chain.v_mps[k] += 0.5 * kGravity_mps2 * (error_s[k + 1] - error_s[k]);
      chain.v_after_mps[k] += 0.5 * kGravity_mps2 * (error_s[k + 2] - error_s[k + 1]);
    }
  }
  const LawWithErrors law{SeriesLaw{}, {}, {}};
  const auto without = reservoir_gains(exact.chains, law, kGravity_mps2);
  const auto with = reservoir_gains(noisy.chains, law, kGravity_mps2);
  for (std::size_t k = 0; k < with.size(); ++k)
    pulls.push_back((with[k].gain_m2ps2 - without[k].gain_m2ps2) / with[k].timing_se_m2ps2);
  EXPECT_NEAR(root_mean_square(pulls), 1.0, 0.15);  // of 200 normal numbers: 1/sqrt(400), three of these
  // the ends of the chain and 1 - eps^2 of what lies between: not the errors of 80 impacts added up
  EXPECT_LT(with.front().timing_se_m2ps2, 2.0 * kGravity_mps2 * kTiming_s * 1.35 * 1.5);
}

TEST(ReservoirGains, HaveTheErrorThatTheLawGivesThemOfEveryForm) {
  const Drawn drawn = drawn_drops(2e-5, 2, 0.0, 5);
  const auto check = [&](const RestitutionLaw& law, const RestitutionLaw& moved, const std::string& name, double step) {
    const auto gains = reservoir_gains(drawn.chains, {law, {{name, {}}}, {{step * step}}}, kGravity_mps2);
    const auto shifted = reservoir_gains(drawn.chains, {moved, {}, {}}, kGravity_mps2);
    // to first order in 1 - eps and v eps', some 2 % each
    EXPECT_NEAR(std::abs(shifted[0].gain_m2ps2 - gains[0].gain_m2ps2), *gains[0].law_se_m2ps2,
                0.05 * *gains[0].law_se_m2ps2);
  };
  check(ViscoelasticLaw{0.02}, ViscoelasticLaw{0.02001}, "gamma", 1e-5);
  check(ConstantLaw{0.98}, ConstantLaw{0.98001}, "eps", 1e-5);
  SeriesLaw moved;
  moved.a[2] += 1e-4;
  moved.a[4] -= 2e-4;
  // errors of A2 and A4 that are one and the same: the standard error is the shift itself
  const LawWithErrors series{SeriesLaw{}, {{"A2", {}}, {"A4", {}}}, {{1e-8, -2e-8}, {-2e-8, 4e-8}}};
  const auto gains = reservoir_gains(drawn.chains, series, kGravity_mps2);
  const auto shifted = reservoir_gains(drawn.chains, {moved, {}, {}}, kGravity_mps2);
  for (std::size_t k = 0; k < gains.size(); ++k)
    EXPECT_NEAR(std::abs(shifted[k].gain_m2ps2 - gains[k].gain_m2ps2), *gains[k].law_se_m2ps2,
                0.05 * *gains[k].law_se_m2ps2);
}

}  // namespace
}  // namespace bouncelab::fit
