// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/detect.hpp"

#include <gtest/gtest.h>
#include <sndfile.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "support/bouncing_sound.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

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
    EXPECT_EQ(d.drops.at(0).begin_s, d.onsets[0].t_s);
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

TEST(Detect, SaysThatSilenceAConstantAndARecordingOfNoSamplesAreSilent) {
  for (const auto& x : {std::vector<float>(48000, 0.0F), std::vector<float>(96000, 0.25F), std::vector<float>{},
                        std::vector<float>(3, 0.1F)}) {
    const Detection d = detect(x, 48e3, "silence");
    EXPECT_EQ(d.status, DetectionStatus::silent) << x.size();
    EXPECT_TRUE(d.onsets.empty());
    EXPECT_FALSE(d.summary.restitution_median.has_value());
  }
}

TEST(Detect, InventsNoTrainFromNoiseOneHitAClockOrKnocksAtRandom) {
  std::vector<float> hit(3 * 48000), clock(20 * 48000);
  test::add_impact(hit, 48e3, 1.0, 0.8);
  test::add_noise(hit, 1e-3, 1);
  EXPECT_EQ(detect(hit, 48e3, "one hit").status, DetectionStatus::too_few_impacts);
  for (int k = 0; k < 38; ++k) test::add_impact(clock, 48e3, 0.5 + 0.5 * k, 0.5);
  test::add_noise(clock, 1e-3, 1);
  EXPECT_TRUE(detect(clock, 48e3, "clock").onsets.empty());
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::vector<float> noise(10 * 48000), knocks(20 * 48000);
    test::add_noise(noise, 0.1, seed);
    EXPECT_TRUE(detect(noise, 48e3, "noise").onsets.empty()) << "seed " << seed;
    // Poisson, 8 a second: what speech or handling looks like to the rise statistic
    Random random(seed, RandomStream::test, 2);
    for (double t_s = 0.0; t_s < 19.9; t_s += random.exponential() / 8.0)
      test::add_impact(knocks, 48e3, t_s, random.uniform(0.05, 0.8));
    test::add_noise(knocks, 1e-3, seed);
    EXPECT_TRUE(detect(knocks, 48e3, "knocks").onsets.empty()) << "seed " << seed;
  }
}

TEST(Detect, NamesTheSampleThatIsNotFinite) {
  std::vector<float> x(48000, 0.0F);
  x[123] = NAN;
  EXPECT_NE(test::refusal<InvalidArgument>([&] { detect(x, 48e3, "nan"); }).find("123"), std::string::npos);
}

constexpr double kRate_hz = 48e3;

TEST(DetectBadInput, FindsTheLiveOneAmongDeadAndNoisyChannels) {
  test::BouncingSound b;
  b.n_impacts = 30;
  const std::vector<float> ball = render(b);
  std::vector<float> noise(ball.size(), 0.0F);
  test::add_noise(noise, 0.3, 2);
  for (const int n_channels : {3, 5, 6}) {
    const int live = n_channels - 2;
    std::vector<float> x;
    for (std::size_t k = 0; k < ball.size(); ++k)
      for (int channel = 0; channel < n_channels; ++channel)
        x.push_back(channel == live ? ball[k] : channel == 0 ? 0.0F : channel == n_channels - 1 ? 0.4F : noise[k]);
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder / "channels.wav";
    SF_INFO info{};
    info.samplerate = static_cast<int>(b.rate_hz);
    info.channels = n_channels;
    info.format = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
    SNDFILE* out = sf_open(file.c_str(), SFM_WRITE, &info);
    ASSERT_NE(out, nullptr);
    sf_writef_float(out, x.data(), static_cast<sf_count_t>(ball.size()));
    sf_close(out);
    const Detection d = detect(file);
    EXPECT_EQ(d.summary.n_channels, n_channels);
    EXPECT_EQ(d.summary.channel, live);
    EXPECT_EQ(d.onsets.size(), 30U) << n_channels << " channels";
  }
}

TEST(DetectBadInput, RefusesARateThatNoRecordingHasAndAGravityThatIsNotPositive) {
  for (const double rate_hz : {1.0, 0.0, -48e3, 1e9, static_cast<double>(NAN)})
    EXPECT_THROW(detect(std::vector<float>(1000, 0.0F), rate_hz, "rate"), InvalidArgument) << rate_hz;
  for (const double gravity_mps2 : {0.0, -9.81, std::numeric_limits<double>::infinity()}) {
    DetectionConfig config;
    config.gravity_mps2 = gravity_mps2;
    EXPECT_THROW(detect(std::vector<float>(48000, 0.0F), 48e3, "silence", config), InvalidArgument) << gravity_mps2;
  }
}

TEST(DetectBadInput, TimesClippedImpactsByATemplateThatIsClippedAlike) {
  test::BouncingSound b;
  b.amplitude = 2.0;
  std::vector<float> x = render(b);
  for (float& v : x) v = std::clamp(v, -0.6F, 0.6F);
  const Detection d = detect(x, kRate_hz, "clipped");
  const std::vector<double> truth = test::impact_times(b);
  ASSERT_EQ(d.onsets.size(), truth.size());
  EXPECT_TRUE(d.onsets.front().flags.has(Flag::clipped));
  EXPECT_FALSE(d.notes.empty());
  // A line in v^(-1/5) is taken off: this sound has no contacts, but the few whole impacts do not rule out steel's.
  const auto n = static_cast<double>(truth.size());
  double u_mean = 0.0, e_mean = 0.0, uu = 0.0, ue = 0.0;
  std::vector<double> u, e;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    u.push_back(std::pow(k > 0 ? truth[k] - truth[k - 1] : truth[1] - truth[0], -0.2));
    e.push_back(d.onsets[k].t_s - truth[k]);
    u_mean += u.back() / n;
    e_mean += e.back() / n;
  }
  for (std::size_t k = 0; k < truth.size(); ++k) {
    uu += (u[k] - u_mean) * (u[k] - u_mean);
    ue += (u[k] - u_mean) * (e[k] - e_mean);
  }
  // a sixteenth of a sample: limiting takes away heights but leaves the zeros
  for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(e[k], e_mean + ue / uu * (u[k] - u_mean), 1.3e-6) << k;
}

TEST(DetectBadInput, TimesARecordingInWhichEveryImpactIsClipped) {
  test::BouncingSound b;
  b.amplitude = 8.0;  // the last, 60th impact is still clipped: 8 * 0.975^59 = 1.8
  std::vector<float> x = render(b);
  for (float& v : x) v = std::clamp(v, -0.6F, 0.6F);
  const Detection d = detect(x, kRate_hz, "all clipped");
  const std::vector<double> truth = test::impact_times(b);
  ASSERT_EQ(d.onsets.size(), truth.size());
  double offset_s = 0.0, square_s2 = 0.0;
  const auto n = static_cast<double>(truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) offset_s += (d.onsets[k].t_s - truth[k]) / n;
  for (std::size_t k = 0; k < truth.size(); ++k) square_s2 += std::pow(d.onsets[k].t_s - offset_s - truth[k], 2) / n;
  // the edges that clipping cuts are the same in every impact but for its strength: within a sample, 21 us
  EXPECT_LT(std::sqrt(square_s2), 1.0 / kRate_hz);
}

}  // namespace
}  // namespace bouncelab::detection
