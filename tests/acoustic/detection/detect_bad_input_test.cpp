// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings without a ball, and bad input: no track, or a clear error.
#include <gtest/gtest.h>

#include <sndfile.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/detection/detect.hpp"
#include "support/bouncing_sound.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 48e3;

TEST(DetectBadInput, SaysThatAConstantIsSilent) {
  const Detection d = detect(std::vector<float>(96000, 0.25F), kRate_hz, "constant");
  EXPECT_EQ(d.status, DetectionStatus::silent);
  EXPECT_TRUE(d.onsets.empty());
  EXPECT_FALSE(d.summary.restitution_median.has_value());
}

TEST(DetectBadInput, FollowsTheBallAfterDigitalZeros) {
  test::BouncingSound b;
  b.n_impacts = 30;
  std::vector<float> x(3 * 48000, 0.0F);
  const std::vector<float> ball = render(b);
  x.insert(x.end(), ball.begin(), ball.end());
  const Detection d = detect(x, kRate_hz, "zeros first");
  ASSERT_EQ(d.onsets.size(), 30U);
  const std::vector<double> truth = test::impact_times(b);
  for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(d.onsets[k].t_s, 3.0 + truth[k], 2.0 / kRate_hz);
}

TEST(DetectBadInput, TakesNoMusicForABall) {
  // plucked notes of a few pitches on a beat, some beats left out: the intervals repeat, they do not shrink
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Random random(seed, RandomStream::test, 4);
    std::vector<float> x(15 * 48000, 0.0F);
    for (double t_s = 0.3; t_s < 14.0; t_s += 0.25) {
      if (random.uniform() < 0.4) continue;
      const double f_hz = 220.0 * std::pow(2.0, std::floor(random.uniform(0.0, 24.0)) / 12.0);
      const double start_s = t_s + 0.005 * random.normal();
      test::ModalSound note{{}, 0.5};
      for (int h = 1; h <= 5; ++h) note.modes.push_back({f_hz * h, 1.0 / 6.0, 1.0 / h});
      test::add_modal_sound(x, kRate_hz, start_s, 0.1, note);
    }
    test::add_noise(x, 1e-3, seed);
    EXPECT_TRUE(detect(x, kRate_hz, "music").onsets.empty()) << "seed " << seed;
  }
}

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

TEST(DetectBadInput, RefusesARateThatNoRecordingHas) {
  for (const double rate_hz : {1.0, 0.0, -48e3, 1e9, static_cast<double>(NAN)})
    EXPECT_THROW(detect(std::vector<float>(1000, 0.0F), rate_hz, "rate"), InvalidArgument) << rate_hz;
}

TEST(DetectBadInput, RefusesAGravityThatIsNotPositive) {
  const std::vector<float> x(48000, 0.0F);
  for (const double gravity_mps2 : {0.0, -9.81, std::numeric_limits<double>::infinity()}) {
    DetectionConfig config;
    config.gravity_mps2 = gravity_mps2;
    EXPECT_THROW(detect(x, 48e3, "silence", config), InvalidArgument) << gravity_mps2;
  }
}

TEST(DetectBadInput, TakesARecordingOfNoSamplesForSilence) {
  EXPECT_EQ(detect(std::vector<float>{}, kRate_hz, "empty").status, DetectionStatus::silent);
  EXPECT_EQ(detect(std::vector<float>(3, 0.1F), kRate_hz, "three samples").status, DetectionStatus::silent);
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
  EXPECT_FALSE(d.warnings.empty());
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
  // a twentieth of a sample: limiting takes away heights but leaves the zeros
  for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(e[k], e_mean + ue / uu * (u[k] - u_mean), 1e-6) << k;
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
