// SPDX-License-Identifier: GPL-3.0-or-later
// Heights by a ruler and times by a stop watch, whose error nobody states: from the text to the interval.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <string>

#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "curve/smooth_curve.hpp"
#include "support/statistics.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kScatter = 0.005;
double eps_by_hand(double v_mps) { return 0.92 - 0.015 * v_mps; }

/// What people write of drops in vacuum: heights, or the times of the impacts; a blank line between drops.
struct ByHand {
  bool heights;
  int n_drops, n_bounces;
  double error, digit;  ///< [m] or [s]

  std::string table(std::uint64_t number) const {
    Random random(64, RandomStream::test, number);
    std::string text = heights ? "h (m)\n" : "Time (s)\n";
    const auto write = [&](double value) {
      std::array<char, 32> cell{};
      std::snprintf(cell.data(), cell.size(), "%.2f\n", digit * std::round((value + error * random.normal()) / digit));
      text += cell.data();
    };
    for (int drop = 0; drop < n_drops; ++drop) {
      if (drop > 0) text += "\n";
      double v_mps = std::sqrt(2.0 * kDefaultGravity_mps2 * random.uniform(0.8, 1.2)), t_s = 1.0;
      for (int k = 0; k <= n_bounces; ++k) {
        write(heights ? 0.5 * v_mps * v_mps / kDefaultGravity_mps2 : t_s);
        v_mps *= eps_by_hand(v_mps) + kScatter * random.normal();
        t_s += 2.0 * v_mps / kDefaultGravity_mps2;
      }
    }
    return text;
  }
};

RestitutionSamples samples_by_hand(const ByHand& by_hand, std::uint64_t number) {
  const ForeignOptions options{by_hand.heights ? "heights" : "times", "auto", ""};
  const TakenTable taken = onsets_from_foreign(read_foreign_table(by_hand.table(number), "x", options));
  RestitutionConfig config;
  config.air_kgpm3 = 0.0;
  config.instant_contacts = true;
  return restitution_samples(onsets_from_table(taken.table, "x"), config).samples;
}

/// Speeds before and after the bounces of one drop, each to 2 % and two digits, as `measured: digits`.
RestitutionSamples speeds_to_two_percent(std::uint64_t number) {
  Random random(65, RandomStream::test, number);
  constexpr double kDigit_mps = 0.01;
  const auto read = [&](double v_mps) {
    return kDigit_mps * std::round(v_mps * (1.0 + 0.02 * random.normal()) / kDigit_mps);
  };
  RestitutionSamples samples;
  for (double v_mps = 4.5; samples.size() < 8;) {
    const double before_mps = read(v_mps);
    v_mps *= eps_by_hand(v_mps) + kScatter * random.normal();
    RestitutionSample& s = samples.emplace_back();
    const double after_mps = read(v_mps);
    s.impact = std::ssize(samples);
    s.v_mps = before_mps, s.eps = after_mps / before_mps;
    s.sigma_eps = s.eps * kDigit_mps / std::sqrt(12.0) * std::hypot(1.0 / before_mps, 1.0 / after_mps);
    s.conditions.sigma_is_least = true;
  }
  return samples;
}

template <class Samples>
void expect_coverage(const char* name, const Samples& samples_of) {
  const int n_tables = test::repetitions(12, 200);
  int n_held = 0, n_without = 0, n_flagged = 0;
  double width = 0.0, error = 0.0;
  for (int number = 0; number < n_tables; ++number) {
    const RestitutionSamples samples = samples_of(static_cast<std::uint64_t>(number));
    for (const RestitutionSample& s : samples) n_flagged += !s.flags.empty();
    LeftOut left_out;
    const PartOfSamples used = usable_samples(samples, left_out);
    const auto nodes = SmoothCurve(*used, places_of(*used), {}).curve().nodes;
    if (nodes.empty() || !nodes[nodes.size() / 2].eps.ci95) {
      ++n_without;
      continue;
    }
    const CurveNode& middle = nodes[nodes.size() / 2];
    const double truth = std::hypot(eps_by_hand(middle.v_mps), kScatter);
    n_held += truth >= middle.eps.ci95->lo && truth <= middle.eps.ci95->hi;
    width += middle.eps.ci95->hi - middle.eps.ci95->lo;
    error += middle.eps.value - truth;
  }
  std::printf("%s: %d of %d held, %d without, mean width %.4f, mean error %.4f, %d flagged\n", name, n_held, n_tables,
              n_without, width / n_tables, error / n_tables, n_flagged);
  EXPECT_EQ(n_without, 0) << name;
  // three standard deviations of the binomial distribution below 95 %: 9.1 of 12, 180.8 of 200
  EXPECT_GE(n_held, std::ceil(0.95 * n_tables - 3.0 * std::sqrt(0.95 * 0.05 * n_tables) - 0.5)) << name;
}

void expect_coverage_by_hand(const char* name, const ByHand& by_hand) {
  expect_coverage(name, [&](std::uint64_t number) { return samples_by_hand(by_hand, number); });
}

TEST(FewDigits, OfHeightsHoldTheTruth) {
  expect_coverage_by_hand("heights of one drop", {true, 1, 7, 0.01, 0.01});
  expect_coverage_by_hand("heights of three drops", {true, 3, 7, 0.01, 0.01});
}

TEST(FewDigits, OfAStopWatchHoldTheTruth) {
  expect_coverage_by_hand("stop watch, three drops", {false, 3, 8, 0.05, 0.01});
}

TEST(FewDigits, OfSpeedsHoldTheTruth) { expect_coverage("speeds before and after", speeds_to_two_percent); }

}  // namespace
}  // namespace bouncelab::fit
