// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/closed_loop.hpp"
#include "support/refusal.hpp"

namespace bouncelab::loop {
namespace {

/// A loop with 100 impacts, eps(0.6 m/s) and slopes at 0.6 m/s as given for the sound; 0.97 and 500 from true times.
LoopResult loop_with(std::size_t n_found, std::size_t n_invented, double eps, double slope) {
  const auto fit = [](double eps_value, double slope_value) {
    fit::FitResult result;
    for (const double v : kNodeSpeeds_mps)
      result.law.nodes.push_back({v, fit::normal_estimate(v == 0.6 ? eps_value : 0.97, 1e-3)});
    fit::HistogramFit window;
    window.v_mps = 0.6;
    window.slope_rising = window.slope_falling = fit::normal_estimate(slope_value, 10.0);
    result.histograms = {window};
    return result;
  };
  LoopResult loop;
  loop.rough.score.agreement[kJitterTolerance] = {100, n_found + n_invented, n_found};
  loop.true_times = fit(0.97, 500.0);
  loop.sound = fit(eps, slope);
  return loop;
}

std::string failure(const LoopResult& loop) { return sweep_point({}, loop).failure; }

TEST(Sweeps, RunThroughEveryCombinationTheLastAxisFastest) {
  const std::vector<SweepAxis> axes{{"radius-law", {"a", "b"}}, {"snr-db", {"10", "20", "30"}}};
  const std::vector<Settings> all = combinations(axes);
  ASSERT_EQ(all.size(), 6u);
  EXPECT_EQ(text_of(all[0]), "radius-law a, snr-db 10");
  EXPECT_EQ(text_of(all[1]), "radius-law a, snr-db 20");
  EXPECT_EQ(text_of(all[5]), "radius-law b, snr-db 30");
  EXPECT_EQ(combinations({}), std::vector<Settings>(1));
}

TEST(Sweeps, OfTooManyCombinationsAreRefusedHoweverManyThereAre) {
  const SweepAxis hundred{"snr-db", std::vector<std::string>(100, "10")};
  EXPECT_EQ(combinations({hundred, hundred}).size(), 10'000u);
  const std::string message = test::refusal<InvalidArgument>([&] { combinations({hundred, hundred, hundred}); });
  EXPECT_NE(message.find("1e+06 combinations"), std::string::npos) << message;
  // 100^40 is beyond every integer
  EXPECT_THROW(combinations(std::vector<SweepAxis>(40, hundred)), InvalidArgument);
}

TEST(Sweeps, JudgeAPointByWhatFailsFirst) {
  EXPECT_EQ(failure(loop_with(0, 0, 0.97, 500)), "nothing found");
  EXPECT_EQ(failure(loop_with(98, 0, 0.97, 500)), "impacts missed");
  EXPECT_EQ(failure(loop_with(100, 2, 0.97, 500)), "impacts invented");
  EXPECT_EQ(failure(loop_with(99, 1, 0.9711, 500)), "eps(0.6 m/s) moved by more than its standard error");
  EXPECT_EQ(failure(loop_with(99, 1, 0.9709, 560)), "slopes at 0.6 m/s moved by more than a tenth");
  EXPECT_EQ(failure(loop_with(99, 1, 0.9709, 540)), "");
  LoopResult no_law = loop_with(100, 0, 0.97, 500);
  no_law.sound.law.nodes.clear();
  EXPECT_EQ(failure(no_law), "no law");
}

TEST(Sweeps, CountTheDropsThatMadeAllTheirImpactsAndTestTheExponentials) {
  LoopResult loop = loop_with(100, 0, 0.97, 500);
  loop.simulation.n_drops = 4;
  loop.simulation.first_drop = 10;
  loop.simulation.n_impacts_max = 2;
  for (const std::int64_t drop : {10, 10, 11, 13, 13}) {  // drop 12 missed the plate
    Impact impact;
    impact.drop = drop;
    loop.rough.impacts.rows.push_back(impact);
  }
  fit::HistogramFit window;
  window.v_mps = 0.6;
  window.pearson = {.p_value = 0.25};
  loop.direct.histograms = {window};
  const Table table = to_table({sweep_point({}, loop)});
  EXPECT_EQ((*table.reals("share_complete"))[0], 0.5);
  EXPECT_EQ((*table.reals("p_exponentials_0.6_simulation"))[0], 0.25);
  EXPECT_TRUE(std::isnan((*table.reals("p_exponentials_0.3_simulation"))[0]));  // no such window
}

TEST(Sweeps, AsATableHaveAColumnForEachSettingAndNumber) {
  const SweepPoint found = sweep_point({{"snr-db", "30"}}, loop_with(100, 0, 0.97, 500));
  const SweepPoint lost = sweep_point({{"snr-db", "0"}}, loop_with(0, 0, 0.97, 500));
  const Table table = to_table(std::vector<SweepPoint>{found, lost});
  EXPECT_EQ(*table.texts("snr_db"), (std::vector<std::string>{"30", "0"}));
  EXPECT_EQ((*table.reals("recall_1ms"))[0], 1.0);
  EXPECT_TRUE(std::isnan((*table.reals("precision_1ms"))[1]));  // of nothing found
  EXPECT_EQ(*table.texts("trouble"), (std::vector<std::string>{"", "nothing found"}));
}

}  // namespace
}  // namespace bouncelab::loop
