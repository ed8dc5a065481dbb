// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/answer.hpp"

#include <gtest/gtest.h>

#include "bouncelab/core/random.hpp"
#include "support/sanitizers.hpp"

namespace bouncelab::report {
using namespace fit;

namespace {

/// Speeds of a drop from 10 cm, eps(v) of the paper, scatter drawn by `draw(random, v)`.
template <class Draw>
RestitutionSamples samples_with(const Draw& draw, std::uint64_t index) {
  const RestitutionLaw law = SeriesLaw{};
  Random random(1, RandomStream::test, index);
  RestitutionSamples samples;
  for (int k = 0; k < 30'000; ++k) {
    RestitutionSample s;
    s.drop = k / 95;
    s.impact = k % 95;
    s.v_mps = random.uniform(0.2, 1.3);
    s.eps = restitution(law, s.v_mps) + draw(random, s.v_mps);
    s.sigma_eps = 1e-7;
    samples.push_back(s);
  }
  return samples;
}

/// Two exponentials of mean 1e-3 / v below, half of it above, `scale` times.
RestitutionSamples rough(double scale = 1.0) {
  return samples_with(
      [scale](Random& random, double v) {
        const double b = scale * 1e-3 / v;
        return random.uniform() < 2.0 / 3.0 ? -b * random.exponential() : 0.5 * b * random.exponential();
      },
      1);
}

Conclusion about(const std::vector<Conclusion>& all, const std::string& word) {
  for (const Conclusion& c : all)
    if (c.claim.find(word) != std::string::npos) return c;
  throw std::runtime_error("no conclusion about " + word);
}

TEST(Conclusions, AllHoldForTwoExponentialsThatNarrowAsTheSpeedGrows) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const FitResult fit = fit_all(rough(), {}), smooth = fit_all(rough(1e-3), {});
  for (const Conclusion& c : paper_conclusions(fit, &smooth, SeriesLaw{})) EXPECT_TRUE(c.holds) << c.claim;
  const Conclusion growth = about(paper_conclusions(fit, &smooth, SeriesLaw{}), "grows");
  ASSERT_TRUE(growth.value && growth.ci95);
  EXPECT_NEAR(*growth.value, -1.0, 0.05);  // 1/v went in; 30,000 samples in 12 bins give about 0.01
}

TEST(Conclusions, ForNormalScatterOfOneWidthTheShapeTheSlopesAndTheGrowthDoNotHold) {
  const FitResult fit = fit_all(samples_with([](Random& r, double) { return 2e-3 * r.normal(); }, 2), {});
  const auto all = paper_conclusions(fit, nullptr, SeriesLaw{});
  EXPECT_EQ(all.size(), 4u);  // nothing is said of a smooth ball that was not there
  EXPECT_FALSE(about(all, "not normal").holds);
  EXPECT_FALSE(about(all, "slopes differ").holds);
  const Conclusion growth = about(all, "grows");
  ASSERT_TRUE(growth.value);
  EXPECT_NEAR(*growth.value, 0.0, 0.05);
}

TEST(Conclusions, PeaksBesideTheLawAreSeen) {
  const FitResult fit = fit_all(rough(), {});
  SeriesLaw other;
  other.a[2] *= 1.1;  // C_2 A_2 v^(1/5) / 10: some 4e-3 of eps, against standard errors of some 2e-5
  EXPECT_FALSE(about(paper_conclusions(fit, nullptr, other), "peaks").holds);
  EXPECT_TRUE(about(paper_conclusions(fit, nullptr, SeriesLaw{}), "peaks").holds);
}

TEST(Conclusions, AScatterThatAsperitiesDoNotMakeIsSeen) {
  if (test::kSanitizer != nullptr) GTEST_SKIP() << test::kRepetitions;
  const FitResult fit = fit_all(rough(), {}), not_so_smooth = fit_all(rough(0.3), {});
  EXPECT_FALSE(about(paper_conclusions(fit, &not_so_smooth, SeriesLaw{}), "asperities").holds);
}

TEST(Conclusions, OfTooFewSamplesHoldNothingAndInventNoNumber) {
  RestitutionSamples few = rough();
  few.resize(10);
  for (const Conclusion& c : paper_conclusions(fit_all(few, {}), nullptr, SeriesLaw{}))
    EXPECT_FALSE(c.holds) << c.claim;
}

}  // namespace
}  // namespace bouncelab::report
