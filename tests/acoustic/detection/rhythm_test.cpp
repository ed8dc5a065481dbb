// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rhythm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

const TrackingModel kModel;
constexpr double kInterval_s = 0.4;
constexpr double kLogAmplitude = 5.0;
constexpr double kSigma_s = 7e-5;

Rhythm after(const std::vector<double>& intervals_s) {
  Rhythm rhythm(std::log(intervals_s.front()), kLogAmplitude);
  for (std::size_t k = 1; k < intervals_s.size(); ++k) rhythm.follow(intervals_s[k], kLogAmplitude, kSigma_s, kModel);
  return rhythm;
}

double density_at(Rhythm rhythm, double interval_s, double log_amplitude = kLogAmplitude) {
  return rhythm.follow(interval_s, log_amplitude, kSigma_s, kModel);  // of the copy
}

/// Sounds at even beats, each off its own by so much of an interval.
std::vector<double> even_row(int n, double scatter, Random& random) {
  std::vector<double> intervals_s;
  for (double last = 0.0; n > 0; --n) {
    const double off = scatter * random.normal();
    intervals_s.push_back(kInterval_s * (1.0 + off - last));
    last = off;
  }
  return intervals_s;
}

/// Each interval that before times a factor, and scattering.
std::vector<double> row_by_hand(int n, double factor, double scatter, Random& random) {
  std::vector<double> intervals_s;
  double interval_s = kInterval_s;
  for (; n > 0; --n, interval_s *= factor) intervals_s.push_back(interval_s * std::exp(scatter * random.normal()));
  return intervals_s;
}

TEST(Rhythm, DensityOverTimeAndLoudnessIntegratesToAboutOne) {
  // over a factor of 4.5 either way, in which irregular intervals are even
  const double reach = std::log(4.5);
  Random random(1, RandomStream::test, 0);
  for (const int n_known : {1, 2, 5, 20}) {
    const Rhythm rhythm = after(even_row(n_known, 0.01, random));
    const double of_time = test::integral(-reach, reach, 20000, [&](double log_ratio) {
      const double interval_s = kInterval_s * std::exp(log_ratio);
      return interval_s * density_at(rhythm, interval_s);
    });
    const double of_loudness = test::integral_over_line(kLogAmplitude, 1.0, 2000,
                                                        [&](double a) { return density_at(rhythm, kInterval_s, a); }) /
                               density_at(rhythm, kInterval_s);
    // beats are left out and divided, each by a probability of its own: 1.065 in all, as irregular ones reach it less
    EXPECT_NEAR(of_time * of_loudness, 1.0, 0.08) << n_known << " intervals";
  }
}

TEST(Rhythm, AnEvenRowIsKnownBetterTheLongerItLasts) {
  const double early = density_at(after(std::vector<double>(2, kInterval_s)), kInterval_s);
  EXPECT_GT(density_at(after(std::vector<double>(20, kInterval_s)), kInterval_s), 1.3 * early);
}

TEST(Rhythm, BeatsLeftOutAndDividedHaveTheirProbabilities) {
  const Rhythm rhythm = after(std::vector<double>(10, kInterval_s));
  const double one = density_at(rhythm, kInterval_s), two = density_at(rhythm, 2.0 * kInterval_s);
  const double lost = 1.0 - kModel.detection_probability;
  EXPECT_NEAR(std::log(two / one), std::log(lost), 1.0);
  EXPECT_NEAR(std::log(density_at(rhythm, 3.0 * kInterval_s) / two), std::log(lost), 1.0);
  EXPECT_NEAR(std::log(density_at(rhythm, 0.5 * kInterval_s) / one), std::log(lost), 1.0);
  EXPECT_GT(two, 3.0 * density_at(rhythm, 1.5 * kInterval_s));
}

TEST(Rhythm, ABeatLeftOutLeavesTheTempoAndADividedOneIsTheNew) {
  const Rhythm even = after({kInterval_s, kInterval_s, kInterval_s, kInterval_s});
  const Rhythm left_out = after({kInterval_s, kInterval_s, kInterval_s, 2.0 * kInterval_s});
  EXPECT_NEAR(density_at(left_out, kInterval_s) / density_at(even, kInterval_s), 1.0, 1e-12);
  const Rhythm divided = after({kInterval_s, kInterval_s, kInterval_s, 0.5 * kInterval_s});
  EXPECT_GT(density_at(divided, 0.5 * kInterval_s), 3.0 * density_at(divided, kInterval_s));
}

TEST(Rhythm, NeitherTheTempoNorTheGainMatters) {
  Random random(3, RandomStream::test, 3);
  const std::vector<double> row = row_by_hand(12, 1.02, 0.03, random);
  Rhythm slow(std::log(2.0 * row[0]), kLogAmplitude + 4.0), fast(std::log(row[0]), kLogAmplitude);
  for (std::size_t k = 1; k < row.size(); ++k) {
    const double a = slow.follow(2.0 * row[k], kLogAmplitude + 4.0, 2.0 * kSigma_s, kModel);
    EXPECT_NEAR(2.0 * a / fast.follow(row[k], kLogAmplitude, kSigma_s, kModel), 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace bouncelab::detection
