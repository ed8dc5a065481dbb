// SPDX-License-Identifier: GPL-3.0-or-later
// What samples say of their drops: above all the height of the release, against drops from known heights.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/report/answer.hpp"
#include "dropped.hpp"

namespace bouncelab::report {
namespace {

using namespace fit;
using ::testing::HasSubstr;
using ::testing::Not;

PlainAnswer answer_of(const RestitutionSamples& samples) { return in_words(fit_all(samples, {}), samples).answer; }
DropsSeen seen_of(const RestitutionSamples& samples) { return answer_of(samples).seen; }

std::string sentence_of_drops(const RestitutionSamples& samples) { return answer_of(samples).sentences.back(); }

TEST(DropsSeen, TellTheHeightOfTheReleaseTheImpactsAndHowLongTheyLast) {
  const Drop drop{.height_m = 0.12};
  const DropsSeen seen = seen_of(samples_of(drop));
  EXPECT_EQ(seen.n_drops, 1u);
  EXPECT_EQ(seen.n_impacts, 20u);
  ASSERT_TRUE(seen.drop_height_m && seen.duration_s && seen.drop_height_ci95_m);
  EXPECT_NEAR(*seen.drop_height_m, 0.12, 1e-6);  // v^2/(2 g); eps is known to 1e-6 by times that are good to 1 us
  EXPECT_LT(seen.drop_height_ci95_m->hi - seen.drop_height_ci95_m->lo, 0.12e-3);
  const Onsets onsets = onsets_of(drop);
  EXPECT_NEAR(*seen.duration_s, onsets.back().t_s - onsets.front().t_s, 1e-9);
}

TEST(DropsSeen, CountImpactsThatAreLikelierThanNotTheBalls) {
  RestitutionSamples samples = samples_of({.height_m = 0.12});
  samples.back().flags = {Flag::improbable};  // the last impact of 20 is the hand that catches the ball
  EXPECT_EQ(seen_of(samples).n_impacts, 19u);
}

TEST(Rebound, OfANamedBallIsWhatItsRuleAsksForOrNot) {
  const double kappa_per_m = drag_per_m(ball_from_text("tennis"), {}, 6.0),
               fall_mps = fall_with_drag_mps(2.54, kG, kappa_per_m);
  const auto answer = [&](const char* ball, double height_m, double eps) {
    RestitutionConfig config;
    config.ball = ball_from_text(ball);
    config.drop_height_m = height_m;
    config.instant_contacts = true;
    const Onsets onsets =
        onsets_of({.height_m = height_m, .eps = [=](int) { return eps; }, .n_impacts = 8, .kappa_per_m = kappa_per_m});
    const RestitutionSamples samples = restitution_samples(onsets, config).samples;
    const FitResult result = fit_all(samples, {});
    return std::pair{result.curve->rebound, in_words(result, samples).answer.sentences};
  };
  const auto eps_of_rebound = [&](double height_m) {
    return std::sqrt(kG / kappa_per_m * std::expm1(2.0 * kappa_per_m * height_m)) / fall_mps;
  };
  for (const auto& [rebound_m, is_within, words] :
       {std::tuple{1.41, std::optional(true), "(ITF) asks for 135 to 147 cm on concrete: within."},
        {1.25, std::optional(false), "on concrete: not within."},
        {1.35, std::optional<bool>(),
         "on concrete: whether it is within is not known, since the interval contains the limit."}}) {
    const auto [rebound, sentences] = answer("tennis", 2.54, eps_of_rebound(rebound_m));
    ASSERT_TRUE(rebound) << rebound_m;
    EXPECT_TRUE(rebound->height_m.ci95->lo < rebound_m && rebound_m < rebound->height_m.ci95->hi) << rebound_m;
    EXPECT_LT(rebound->height_m.ci95->hi - rebound->height_m.ci95->lo, 0.03) << rebound_m;  // drag is known to 10 %
    EXPECT_NEAR(rebound->v_mps, fall_mps, 0.01 * fall_mps);  // its drag goes with the speed: 3 % of 7 %
    EXPECT_EQ(rebound->is_within(), is_within) << rebound_m;
    EXPECT_THAT(sentences, ::testing::Contains(::testing::AllOf(::testing::StartsWith("Dropped from 254 cm this ball"),
                                                                ::testing::EndsWith(words))));
  }
  EXPECT_TRUE(answer("tennis", 2.4, 0.75).first);  // by a tenth less high eps is hardly another
  EXPECT_FALSE(answer("tennis", 2.0, 0.75).first);
  EXPECT_FALSE(answer("golf", 2.54, 0.75).first);
}

TEST(Rebound, OfSpeedsThatWereMeasuredIsThroughTheAirToo) {
  RestitutionSamples samples(6);
  for (std::size_t k = 0; k < samples.size(); ++k)
    samples[k].v_mps = 6.0 + 0.3 * static_cast<double>(k), samples[k].eps = 0.75,
    samples[k].conditions.ball = ball_from_text("tennis");
  const auto rebound = fit_all(samples, {}).curve->rebound;
  ASSERT_TRUE(rebound);
  const double kappa_per_m = drag_per_m(ball_from_text("tennis"), {}, 5.3);
  const double through_air_m = rise_height_m(0.75 * fall_with_drag_mps(2.54, kG, kappa_per_m), kG, kappa_per_m);
  EXPECT_NEAR(rebound->height_m.value, through_air_m, 0.005);  // C_d of one speed for both ways
  EXPECT_LT(rebound->height_m.value, 0.75 * 0.75 * 2.54 - 0.04);
}

TEST(DropsSeen, LastSecondsMinutesOrHours) {
  for (const auto& [t_s, words] : {std::pair{100.0, " in 100 s."}, {3000.0, " in 50 min."}, {10800.0, " in 3.0 h."}}) {
    const double v_mps = 0.5 * kG * t_s * 0.1 / 0.9 / (1.0 - std::pow(0.9, 19));  // nineteen flights of 2 eps^k v/g
    EXPECT_THAT(sentence_of_drops(samples_of({.height_m = 0.5 * v_mps * v_mps / kG})), ::testing::EndsWith(words));
  }
}

TEST(DropsSeen, TakeTheDragOfANamedBallIntoAccount) {
  RestitutionConfig config;
  config.ball = ball_from_text("table-tennis");
  config.instant_contacts = true;
  const double kappa_per_m = drag_per_m(*config.ball, {}, 2.5);
  const RestitutionSamples samples =
      restitution_samples(onsets_of({.height_m = 1.0, .kappa_per_m = kappa_per_m}), config).samples;
  const DropsSeen seen = seen_of(samples);
  ASSERT_TRUE(seen.drop_height_m && seen.drop_height_ci95_m);
  // by v^2/(2 g) and the median eps' of the intervals .87: the drag takes a tenth
  EXPECT_NEAR(*seen.drop_height_m, 1.0, 0.02);  // kappa goes with the speed, in the fit and not in these flights: 4 %
  EXPECT_LT(seen.drop_height_ci95_m->lo, 1.0);
  EXPECT_GT(seen.drop_height_ci95_m->hi, 1.0);
  EXPECT_LT(seen.drop_height_ci95_m->hi / seen.drop_height_ci95_m->lo, 1.1);  // kappa is known to 10 %
  EXPECT_THAT(sentence_of_drops(samples), HasSubstr("Dropped from about "));
  EXPECT_THAT(sentence_of_drops(samples), HasSubstr(" m); from 20 impacts"));
}

TEST(DropsSeen, KnowNoHeightWhereWhichImpactIsTheFirstCannotBeTold) {
  // released at the first sample: a bounce before the first impact seen would lie before the recording
  EXPECT_FALSE(seen_of(samples_of({.height_m = 0.12, .begin_s = 0.0})).drop_height_m);
  RestitutionSamples late = samples_of({.height_m = 0.12}), flagged = late;
  late.erase(late.begin());  // the first impact was not detected
  EXPECT_FALSE(seen_of(late).drop_height_m);
  EXPECT_EQ(seen_of(late).n_impacts, 19u);
  flagged.front().flags.add(Flag::missing_impact);
  EXPECT_FALSE(seen_of(flagged).drop_height_m);
  // struck from below at impact 4
  EXPECT_FALSE(seen_of(samples_of({.height_m = 0.12, .eps = [](int k) { return k == 4 ? 1.7 : 0.9; }})).drop_height_m);
  const auto of_two = [](double pause_s) {
    Onsets onsets = onsets_of({.height_m = 0.12});
    const Onsets second = onsets_of({.height_m = 0.12, .begin_s = onsets.back().t_s + pause_s, .number = 1});
    onsets.insert(onsets.end(), second.begin(), second.end());
    return seen_of(fit::restitution_samples(onsets, no_air()).samples);
  };
  EXPECT_EQ(of_two(1.0).n_heights, 2u);
  // the bounce before the second one's first impact would have begun .31 s before that, 2 v/g, and .16 s is its fall
  EXPECT_EQ(of_two(0.1).n_heights, 1u);
}

TEST(DropsSeen, HaveTheHeightInTheirIntervalAndTheNextFlightBelowIt) {
  std::mt19937 random(7);
  std::normal_distribution<double> scatter(0.0, 0.01);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  constexpr int kDrops = 40;
  int n_held = 0;
  for (int i = 0; i < kDrops; ++i) {
    const double height_m = 0.1 + 1.4 * any(random), eps = 0.6 + 0.35 * any(random);
    Drop drop{.height_m = height_m};
    drop.n_impacts = i % 2 == 0 ? 5 : 12;
    std::vector<double> each(drop.n_impacts);
    for (double& e : each) e = eps + scatter(random);
    drop.eps = [&](int k) { return each[static_cast<std::size_t>(k)]; };
    const RestitutionSamples samples = samples_of(drop);
    const DropsSeen seen = seen_of(samples);
    ASSERT_TRUE(seen.drop_height_m && seen.drop_height_ci95_m) << i;
    const double rise_m = samples.front().v_mps * samples.front().v_mps / (2.0 * kG);
    EXPECT_GE(*seen.drop_height_m, rise_m);
    EXPECT_GE(seen.drop_height_ci95_m->lo, rise_m);
    n_held += seen.drop_height_ci95_m->lo <= height_m && height_m <= seen.drop_height_ci95_m->hi;
  }
  EXPECT_GE(n_held, 34);  // of 95 %, fewer once in 200 times
}

constexpr double kOff = 0.055;  // h goes as 1/eps^2, and eps at the first impact, 0.81, may be taken for 0.79

/// Which of the two it is, is drawn: alternating, drops of these heights would agree on an eps that goes up and down
/// with the speed.
RestitutionSamples drops_from(const std::vector<double>& heights_m) {
  RestitutionSamples samples;
  std::mt19937 random(8);
  for (std::size_t k = 0; k < heights_m.size(); ++k) {
    std::vector<double> each(9);
    for (double& eps : each) eps = random() % 2 == 0 ? 0.81 : 0.79;
    const auto of_one = samples_of({.height_m = heights_m[k],
                                    .eps = [&](int impact) { return each[static_cast<std::size_t>(impact)]; },
                                    .n_impacts = each.size(),
                                    .begin_s = 10.0 + 20.0 * static_cast<double>(k),
                                    .number = static_cast<std::int64_t>(k)});
    samples.insert(samples.begin(), of_one.rbegin(), of_one.rend());
  }
  return samples;
}

TEST(DropsSeen, OfSeveralDropsFromOneHeightTakeTheMedianInAnyOrderOfTheSamples) {
  const RestitutionSamples samples = drops_from({0.201, 0.199, 0.2});
  const DropsSeen seen = seen_of(samples);
  EXPECT_EQ(seen.n_heights, 3u);
  EXPECT_NEAR(seen.drop_height_m.value_or(0.0), 0.2, 0.2 * kOff);
  EXPECT_FALSE(seen.drop_heights_m);
  EXPECT_EQ(seen.n_impacts, 27u);
  EXPECT_THAT(sentence_of_drops(samples), HasSubstr("; median of the 3 drops whose first impact was heard)"));
}

TEST(DropsSeen, OfDropsFromDifferentHeightsTellTheRange) {
  for (const std::vector<double>& heights_m : {std::vector{0.65, 1.68}, {0.3, 0.13, 0.06, 0.06, 0.027}}) {
    const RestitutionSamples samples = drops_from(heights_m);
    const DropsSeen seen = seen_of(samples);
    ASSERT_TRUE(seen.drop_heights_m) << heights_m.size();
    EXPECT_FALSE(seen.drop_height_ci95_m);
    const auto [least, greatest] = std::minmax_element(heights_m.begin(), heights_m.end());
    EXPECT_NEAR(seen.drop_heights_m->lo / *least, 1.0, kOff);
    EXPECT_NEAR(seen.drop_heights_m->hi / *greatest, 1.0, kOff);
    EXPECT_THAT(sentence_of_drops(samples), HasSubstr(heights_m.size() == 2 ? "Dropped from 0.6" : "Dropped from 2."));
    EXPECT_THAT(sentence_of_drops(samples), HasSubstr(" (the "));
  }
}

TEST(DropsSeen, OfBouncesThatScatterWidelyTellTheLeastHeightAlone) {
  const double eps[] = {0.75, 0.6, 0.8, 0.6, 0.7, 0.65, 0.8};
  const RestitutionSamples samples =
      samples_of({.height_m = 0.5, .eps = [&](int k) { return eps[k]; }, .n_impacts = 7, .begin_s = 20.0});
  const DropsSeen seen = seen_of(samples);
  ASSERT_TRUE(seen.drop_height_ci95_m);
  EXPECT_GT(seen.drop_height_ci95_m->hi, 2.0 * seen.drop_height_ci95_m->lo);
  EXPECT_THAT(sentence_of_drops(samples), HasSubstr("Dropped from at least "));
  EXPECT_THAT(sentence_of_drops(samples), Not(HasSubstr(" to ")));
}

TEST(DropsSeen, OfAHeightThatWasGivenSayThatOne) {
  RestitutionConfig config = no_air();
  config.drop_height_m = 0.12;
  const DropsSeen seen = seen_of(restitution_samples(onsets_of({.height_m = 0.12}), config).samples);
  EXPECT_NEAR(seen.drop_height_m.value_or(0.0), 0.12, 1e-12);  // but for rounding
  EXPECT_FALSE(seen.drop_height_ci95_m);
}

TEST(DropsSeen, OfATableOfSpeedsAndEpsAloneKnowNeitherImpactsNorTimes) {
  RestitutionSamples samples(10);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].impact = static_cast<std::int64_t>(k);  // as such a table is read
    samples[k].v_mps = 1.0 - 0.01 * static_cast<double>(k);
    samples[k].eps = 0.9;
  }
  const DropsSeen seen = seen_of(samples);
  EXPECT_FALSE(seen.n_impacts || seen.duration_s || seen.drop_height_m);
}

}  // namespace
}  // namespace bouncelab::report
