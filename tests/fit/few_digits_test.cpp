// SPDX-License-Identifier: GPL-3.0-or-later
// Heights by a ruler and times by a stop watch, whose error nobody states: from the text to the interval.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>

#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/fit/usable_samples.hpp"
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
  const TakenTable taken = onsets_from_foreign(read_foreign_table(by_hand.table(number), "x", options), "x", options);
  RestitutionConfig config;
  config.air_kgpm3 = 0.0;
  config.instant_contacts = true;
  return restitution_samples(onsets_from_table(taken.table, "x"), config).samples;
}

void expect_coverage(const char* name, const ByHand& by_hand) {
  const int n_tables = test::repetitions(12, 200);
  int n_held = 0, n_without = 0, n_flagged = 0;
  double width = 0.0, error = 0.0;
  for (int number = 0; number < n_tables; ++number) {
    const RestitutionSamples samples = samples_by_hand(by_hand, static_cast<std::uint64_t>(number));
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

TEST(FewDigits, OfHeightsHoldTheTruth) {
  for (const int n_drops : {1, 3})
    expect_coverage(n_drops == 1 ? "heights of one drop" : "heights of three drops", {true, n_drops, 7, 0.01, 0.01});
}

TEST(FewDigits, OfAStopWatchHoldTheTruth) { expect_coverage("stop watch, three drops", {false, 3, 8, 0.05, 0.01}); }

}  // namespace
}  // namespace bouncelab::fit
