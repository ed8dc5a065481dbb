// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rhythm.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "candidate_rows.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kInterval_s = 0.4;
constexpr double kLogAmplitude = 5.0;
constexpr double kSigma_s = 7e-5;
using Densities = std::array<double, kRhythmKinds>;
constexpr std::size_t kByHand = 0, kByMachine = 1;

Rhythm after(const std::vector<double>& intervals_s) {
  Rhythm rhythm(std::log(intervals_s.front()), kLogAmplitude);
  for (std::size_t k = 1; k < intervals_s.size(); ++k) rhythm.follow(intervals_s[k], kLogAmplitude, kSigma_s);
  return rhythm;
}

Densities densities_at(Rhythm rhythm, double interval_s, double log_amplitude = kLogAmplitude) {
  return rhythm.follow(interval_s, log_amplitude, kSigma_s);  // of the copy
}

/// Sum of the log densities, by kind.
Densities log_densities_of(const std::vector<double>& intervals_s) {
  Rhythm rhythm(std::log(intervals_s.front()), kLogAmplitude);
  Densities sum{};
  for (std::size_t k = 1; k < intervals_s.size(); ++k) {
    const Densities densities = rhythm.follow(intervals_s[k], kLogAmplitude, kSigma_s);
    for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) sum[kind] += std::log(densities[kind]);
  }
  return sum;
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

TEST(Rhythm, DensitiesOverTimeAndLoudnessIntegrateToAboutOne) {
  // over a factor of 4.5 either way, in which irregular intervals are even
  const double reach = std::log(4.5);
  Random random(1, RandomStream::test, 0);
  for (const int n_known : {1, 2, 5, 20}) {
    const Rhythm rhythm = after(even_row(n_known, 0.01, random));
    Densities sum{};
    for (std::size_t kind = 0; kind < kRhythmKinds; ++kind)
      sum[kind] = test::integral(-reach, reach, 20000, [&](double log_ratio) {
        const double interval_s = kInterval_s * std::exp(log_ratio);
        return interval_s * densities_at(rhythm, interval_s)[kind];
      });
    const double of_loudness =
        test::integral_over_line(kLogAmplitude, 1.0, 2000,
                                 [&](double a) { return densities_at(rhythm, kInterval_s, a)[kByHand]; }) /
        densities_at(rhythm, kInterval_s)[kByHand];
    for (std::size_t kind = 0; kind < kRhythmKinds; ++kind)
      // beats are left out and divided, each by a probability of its own: 1.065 in all, as irregular ones reach it less
      EXPECT_NEAR(sum[kind] * of_loudness, 1.0, 0.08) << n_known << " intervals, kind " << kind;
  }
}

TEST(Rhythm, AMachinesRowIsFollowedBetterByMachine) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed, RandomStream::test, 0);
    const Densities sum = log_densities_of(even_row(20, 0.005, random));
    EXPECT_GT(sum[kByMachine], sum[kByHand] + 5.0) << seed;
  }
}

TEST(Rhythm, AHandsTrendIsFollowedBetterByHand) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed, RandomStream::test, 1);
    const Densities sum = log_densities_of(row_by_hand(20, 0.93, 0.02, random));
    EXPECT_GT(sum[kByHand], sum[kByMachine] + 3.0) << seed;
  }
}

TEST(Rhythm, AnEvenRowIsKnownBetterTheLongerItLasts) {
  Random random(1, RandomStream::test, 2);
  const Densities early = densities_at(after(std::vector<double>(2, kInterval_s)), kInterval_s);
  const Densities late = densities_at(after(std::vector<double>(20, kInterval_s)), kInterval_s);
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) EXPECT_GT(late[kind], 1.3 * early[kind]) << kind;
}

TEST(Rhythm, BeatsLeftOutAndDividedHaveTheirProbabilities) {
  const Rhythm rhythm = after(std::vector<double>(10, kInterval_s));
  const Densities one = densities_at(rhythm, kInterval_s);
  const double lost = 1.0 - kTracking.detection_probability;
  // widths are those of the interval's logarithm by hand, of the time itself by machine
  const Densities two = densities_at(rhythm, 2.0 * kInterval_s), three = densities_at(rhythm, 3.0 * kInterval_s);
  const Densities half = densities_at(rhythm, 0.5 * kInterval_s);
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    EXPECT_NEAR(std::log(two[kind] / one[kind]), std::log(lost), 1.0) << kind;
    EXPECT_NEAR(std::log(three[kind] / two[kind]), std::log(lost), 1.0) << kind;
    EXPECT_NEAR(std::log(half[kind] / one[kind]), std::log(lost), 1.0) << kind;
    EXPECT_GT(two[kind], 3.0 * densities_at(rhythm, 1.5 * kInterval_s)[kind]) << kind;
  }
}

TEST(Rhythm, NeitherTheTempoNorTheGainMatters) {
  Random random(3, RandomStream::test, 3);
  const std::vector<double> row = row_by_hand(12, 1.02, 0.03, random);
  Rhythm slow(std::log(2.0 * row[0]), kLogAmplitude + 4.0), fast(std::log(row[0]), kLogAmplitude);
  for (std::size_t k = 1; k < row.size(); ++k) {
    const Densities a = slow.follow(2.0 * row[k], kLogAmplitude + 4.0, 2.0 * kSigma_s);
    const Densities b = fast.follow(row[k], kLogAmplitude, kSigma_s);
    for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) EXPECT_NEAR(2.0 * a[kind] / b[kind], 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace bouncelab::detection
