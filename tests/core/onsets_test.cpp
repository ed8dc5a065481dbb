// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/onsets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/random.hpp"
#include "support/refusal.hpp"

namespace bouncelab {
namespace {

TEST(Flags, KeepTheOrderInWhichTheyWereSet) {
  Flags flags;
  flags.add(Flag::overlap);
  flags.add(Flag::clipped);
  flags.add(Flag::overlap);
  EXPECT_EQ(flags.text(), "overlap|clipped");
  EXPECT_EQ(flags.first_word(), "overlap");
  EXPECT_NE(flags, (Flags{Flag::clipped, Flag::overlap}));
  // and are whole words
  const Flags words = Flags::from_text("overlapping|unclipped|not_finite");
  EXPECT_FALSE(words.has(Flag::overlap) || words.has(Flag::clipped));
  EXPECT_TRUE(words.has(Flag::not_finite));
  EXPECT_TRUE(Flags::from_text("").empty());
}

TEST(Flags, KeepWordsThatAreNotOurs) {
  Flags flags = Flags::from_text("noisy|clipped||");
  flags.add(Flag::clipped);
  EXPECT_EQ(flags.text(), "noisy|clipped||");
  flags.add(Flag::by_hand);
  EXPECT_EQ(flags.text(), "noisy|clipped|||by_hand");
  EXPECT_EQ(flags.first_word(), "noisy");
}

TEST(Flags, AreFoundByTheWordsThatTheyWrite) {
  for (int k = 0; k <= static_cast<int>(Flag::overlap); ++k) {
    const auto flag = static_cast<Flag>(k);
    EXPECT_EQ(flag_named(name_of(flag)), flag);
    EXPECT_TRUE(Flags::from_text(std::string(name_of(flag))).has(flag)) << name_of(flag);
  }
  EXPECT_FALSE(flag_named("clip").has_value());
  EXPECT_FALSE(flag_named("").has_value());
}

/// Standard error that times of one drop get, written with `decimals`.
std::optional<double> sigma_of(const std::vector<double>& t_s, int decimals) {
  Table table;
  table.columns.push_back({"t_s", std::vector<double>{}, decimals});
  const double digit_s = std::pow(10.0, -decimals);
  for (const double t : t_s)
    std::get<std::vector<double>>(table.columns[0].values).push_back(digit_s * std::round(t / digit_s));
  const Onsets onsets = onsets_from_table(table, "t.csv");
  for (const Onset& onset : onsets) EXPECT_EQ(onset.sigma_t_s, onsets.front().sigma_t_s);
  return onsets.front().sigma_t_s;
}

TEST(Onsets, OnAGridThatTheirDigitsHideHaveItsStandardError) {
  Random rng(1, RandomStream::test, 0);
  int n = 0, n_coarser = 0;  // all may be even by chance, and so on a grid of half the places
  for (int drop = 0; drop < 200; ++drop) {
    std::vector<double> t_s{rng.uniform()};
    for (double flight_s = 0.8; t_s.size() < 8; flight_s *= 0.8) t_s.push_back(t_s.back() + flight_s);
    EXPECT_FALSE(sigma_of(t_s, 6)) << drop;  // any times: the chance of a grid is 1e-6
    for (const double rate_hz : {24.0, 30.0, 30.0 / 1.001, 240.0, 1000.0}) {
      std::vector<double> on_grid;
      for (const double t : t_s) on_grid.push_back(std::round(t * rate_hz) / rate_hz);
      for (const int decimals : {6, 9}) {
        const auto sigma_s = sigma_of(on_grid, decimals);
        ASSERT_TRUE(sigma_s) << rate_hz << " Hz, " << decimals << " decimals";
        const double ratio = *sigma_s * std::sqrt(12.0) * rate_hz;
        EXPECT_NEAR(ratio, std::max(1.0, std::round(ratio)), 2e-3) << rate_hz;
        n += 1, n_coarser += ratio > 1.5 ? 1 : 0;
      }
    }
  }
  EXPECT_LT(n_coarser, 0.1 * n);  // 2^-7 + 3^-7 of any eight; these flights differ by their rounding only
  // hundredths tell nothing of a grid of 1/30 s, ten thousandths do
  EXPECT_NEAR(sigma_of({0.1, 0.9, 1.53333, 2.0, 2.36667, 2.66667}, 2).value_or(0.0), 0.01 / std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(sigma_of({0.1, 0.9, 1.53333, 2.0, 2.36667, 2.66667}, 4).value_or(0.0), 1.0 / 30 / std::sqrt(12.0), 1e-12);
}

TEST(Onsets, RoundTripThroughTheTableKeepsWhatIsNotKnown) {
  const Onsets onsets{{"a.wav", 0, 0, 0.5, 1e-6, 0.3, std::nullopt, {Flag::clipped}},
                      {"a.wav", 0, 1, 0.7, std::nullopt, 0.2, 30.0, {}, 0.875}};
  const Onsets back = onsets_from_table(to_table(onsets), "a.csv");
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(back[0].sigma_t_s, 1e-6);
  EXPECT_FALSE(back[0].snr_db.has_value());
  EXPECT_FALSE(back[1].sigma_t_s.has_value());
  EXPECT_EQ(back[0].flags, Flags{Flag::clipped});
  EXPECT_EQ(back[1].impact, 1);
  EXPECT_FALSE(back[0].probability.has_value());
  EXPECT_EQ(back[1].probability, 0.875);
}

TEST(Onsets, AProbabilityAboveOneIsRefused) {
  const Table table{{{"t_s", std::vector<double>{0.1}}, {"probability", std::vector<double>{1.5}}}};
  EXPECT_THROW(onsets_from_table(table, "times.csv"), FileError);
}

TEST(Onsets, BareTimesAreOneDropNumberedInOrder) {
  const Onsets onsets = onsets_from_table(Table{{{"t_s", std::vector<double>{0.1, 0.3, 0.4}}}}, "times.csv");
  EXPECT_EQ(onsets[2].drop, 0);
  EXPECT_EQ(onsets[2].impact, 2);
}

TEST(Onsets, ANewDropMayStartAtAnEarlierTime) {
  const Table table{{{"drop", std::vector<std::int64_t>{0, 0, 1}}, {"t_s", std::vector<double>{0.1, 0.3, 0.2}}}};
  EXPECT_EQ(onsets_from_table(table, "t.csv").size(), 3u);
}

TEST(DropsInTurn, AreRowsThatStandTogetherInTheirOrderAndOnce) {
  const auto table = [](std::vector<std::string> recordings, std::vector<std::int64_t> drops,
                        std::vector<std::int64_t> impacts) {
    return Table{{{"recording", std::move(recordings)}, {"drop", std::move(drops)}, {"impact", std::move(impacts)}}};
  };
  const Table whole = table({"a", "a", "a", "b"}, {0, 0, 3, 0}, {0, 4, 0, 2});
  EXPECT_NO_THROW(DropsInTurn().check(whole, "t.csv"));
  for (const Table& wrong : {table({"a", "a", "a"}, {0, 1, 0}, {0, 0, 1}),   // two balls in the order of time
                             table({"a", "b", "a"}, {0, 0, 0}, {0, 0, 1}),   // sorted by something else
                             table({"a", "a", "a"}, {0, 0, 0}, {0, 1, 1})})  // a row twice
    EXPECT_THAT(test::refusal<FileError>([&] { DropsInTurn().check(wrong, "t.csv"); }),
                testing::AllOf(testing::HasSubstr("t.csv: row 3: "), testing::HasSubstr("sort the table")));
  DropsInTurn in_pieces;
  in_pieces.check(whole, "t.csv");
  EXPECT_NO_THROW(in_pieces.check(table({"b"}, {0}, {3}), "t.csv"));
  EXPECT_THROW(in_pieces.check(table({"a"}, {3}, {1}), "t.csv"), FileError);
}

TEST(Impacts, StatesSurviveTheRoundTrip) {
  Impacts impacts;
  impacts.rows.push_back({3, 0, 0.1, 1.2, 1.1, 1.1 / 1.2, 1.21, 0.98, 17});
  impacts.states.push_back({{1, 2, 3}, {1, 0, 0, 0}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}, {13, 14, 15}});
  const Impacts back = impacts_from_table(to_table(impacts), "i.csv");
  ASSERT_EQ(back.states.size(), 1u);
  EXPECT_EQ(back.rows[0].asperity, 17);
  EXPECT_EQ(back.states[0].spin_after_radps, (std::array<double, 3>{13, 14, 15}));
}

}  // namespace
}  // namespace bouncelab
