// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/detect.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/error.hpp"
#include "support/bouncing_sound.hpp"

namespace bouncelab::detection {
namespace {

using test::BouncingSound;

/// Every true time has its onset within the tolerance and there are no others.
void expect_all_found(const std::vector<double>& truth, const Onsets& onsets, double tolerance_s) {
  ASSERT_EQ(onsets.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(onsets[k].t_s, truth[k], tolerance_s) << "impact " << k;
    EXPECT_EQ(onsets[k].impact, static_cast<std::int64_t>(k));
  }
}

TEST(Detect, FindsEveryImpactOfACleanDropToASample) {
  const BouncingSound b;
  const std::vector<float> x = render(b);
  const Detection d = detect(x, b.rate_hz, "clean");
  EXPECT_EQ(d.status, DetectionStatus::ok);
  EXPECT_EQ(d.summary.n_drops, 1);
  expect_all_found(test::impact_times(b), d.onsets, 2.0 / b.rate_hz);
}

TEST(Detect, TimesALastImpactWhereASingleGainHasPutIt) {
  // spin returns energy: the last flight is as long as the one before, 2 % longer than eps says and beyond
  // where an impact is looked for; a side lobe of its sound lies within
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    BouncingSound b;
    b.rate_hz = 96e3;
    b.eps = 0.98;
    b.eps_scatter = 0.001;
    b.n_impacts = 80;
    b.seed = seed;
    std::vector<double> truth = test::impact_times(b);
    truth.back() = truth[78] + (truth[78] - truth[77]) * 1.0003;
    std::vector<float> x(static_cast<std::size_t>((truth.back() + b.tail_s) * b.rate_hz));
    for (std::size_t k = 0; k < truth.size(); ++k)
      test::add_impact(x, b.rate_hz, truth[k], b.amplitude * std::pow(b.eps, static_cast<double>(k)));
    test::add_noise(x, b.noise_rms, seed);
    expect_all_found(truth, detect(x, b.rate_hz, "gain").onsets, 2.0 / b.rate_hz);
  }
}

TEST(Detect, TellsTwoDropsApart) {
  BouncingSound first;
  first.n_impacts = 30;
  BouncingSound second = first;
  second.seed = 2;
  std::vector<float> x = render(first);
  const double shift_s = static_cast<double>(x.size()) / first.rate_hz;
  const std::vector<float> y = render(second);
  x.insert(x.end(), y.begin(), y.end());
  std::vector<double> truth = test::impact_times(first);
  for (const double t_s : test::impact_times(second)) truth.push_back(t_s + shift_s);
  const Detection d = detect(x, first.rate_hz, "two");
  EXPECT_EQ(d.summary.n_drops, 2);
  ASSERT_EQ(d.onsets.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(d.onsets[k].t_s, truth[k], 2.0 / first.rate_hz);
    EXPECT_EQ(d.onsets[k].drop, k < 30 ? 0 : 1);
  }
}

TEST(Detect, ZerosAroundARecordingChangeNothingButItsBegin) {
  // ten minutes of a muted microphone, a decoder's zeros (Opus) among them; after the drop, and around two far apart
  test::BouncingSound b;
  b.rate_hz = 8000.0;
  b.n_impacts = 20;
  const std::vector<float> sound = render(b);
  const auto minutes = [&](double n, float zero) {
    return std::vector<float>(static_cast<std::size_t>(n * 60.0 * b.rate_hz), zero);
  };
  const auto joined = [](std::vector<float> x, const std::vector<float>& y) {
    x.insert(x.end(), y.begin(), y.end());
    return x;
  };
  const Detection expected = detect(sound, b.rate_hz, "sound");
  ASSERT_EQ(expected.onsets.size(), 20U);
  for (const float zero : {0.0F, 2e-34F}) {
    const std::vector<float> muted = joined(joined(minutes(10.0, zero), sound), minutes(5.0, zero));
    const Detection d = detect(muted, b.rate_hz, "muted");
    ASSERT_EQ(d.onsets.size(), expected.onsets.size());
    EXPECT_EQ(d.summary.duration_s, static_cast<double>(muted.size()) / b.rate_hz);
    for (std::size_t k = 0; k < d.onsets.size(); ++k) {
      EXPECT_NEAR(d.onsets[k].t_s - 600.0, expected.onsets[k].t_s, 1e-12);  // rounding at 600 s
      EXPECT_EQ(d.onsets[k].sigma_t_s, expected.onsets[k].sigma_t_s);
    }
  }
  // noise is learned where there is sound, of which evenly spread blocks would meet none in four hours
  const Detection far = detect(joined(joined(sound, minutes(240.0, 0.0F)), sound), b.rate_hz, "far apart");
  EXPECT_EQ(far.summary.n_drops, 2);
  EXPECT_EQ(far.onsets.size(), 40U);
}

TEST(Detect, SaysThatSilenceIsSilent) {
  const std::vector<float> x(48000, 0.0F);
  const Detection d = detect(x, 48e3, "silence");
  EXPECT_EQ(d.status, DetectionStatus::silent);
  EXPECT_TRUE(d.onsets.empty());
}

TEST(Detect, InventsNothingInNoise) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::vector<float> x(10 * 48000);
    test::add_noise(x, 0.1, seed);
    EXPECT_TRUE(detect(x, 48e3, "noise").onsets.empty()) << "seed " << seed;
  }
}

TEST(Detect, InventsNoTrainFromOneHit) {
  std::vector<float> x(3 * 48000);
  test::add_impact(x, 48e3, 1.0, 0.8);
  test::add_noise(x, 1e-3, 1);
  const Detection d = detect(x, 48e3, "one hit");
  EXPECT_EQ(d.status, DetectionStatus::too_few_impacts);
  EXPECT_TRUE(d.onsets.empty());
}

TEST(Detect, InventsNoTrainFromKnocksAtRandom) {
  // Poisson knocks, 8 a second: what speech or handling looks like to the rise statistic
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::vector<float> x(20 * 48000);
    Random random(seed, RandomStream::test, 2);
    for (double t_s = 0.0; t_s < 19.9; t_s += random.exponential() / 8.0)
      test::add_impact(x, 48e3, t_s, random.uniform(0.05, 0.8));
    test::add_noise(x, 1e-3, seed);
    EXPECT_TRUE(detect(x, 48e3, "knocks").onsets.empty()) << "seed " << seed;
  }
}

TEST(Detect, TakesNoClockForABall) {
  std::vector<float> x(20 * 48000);
  for (int k = 0; k < 38; ++k) test::add_impact(x, 48e3, 0.5 + 0.5 * k, 0.5);
  test::add_noise(x, 1e-3, 1);
  EXPECT_TRUE(detect(x, 48e3, "subband").onsets.empty());
}

TEST(Detect, NamesTheSampleThatIsNotFinite) {
  std::vector<float> x(48000, 0.0F);
  x[123] = NAN;
  try {
    detect(x, 48e3, "nan");
    FAIL() << "accepted";
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("123"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace bouncelab::detection
