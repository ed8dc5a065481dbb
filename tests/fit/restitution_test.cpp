// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/restitution.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <tuple>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/table.hpp"
#include "support/refusal.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using ::testing::StartsWith;

Onsets onsets_at(const std::vector<double>& times, std::int64_t drop = 0) {
  Onsets onsets;
  for (const double t : times) {
    Onset o;
    o.drop = drop;
    o.impact = static_cast<std::int64_t>(onsets.size());
    o.t_s = t;
    o.sigma_t_s = 1e-5;
    onsets.push_back(o);
  }
  return onsets;
}

/// A ball of constant eps: intervals T, eps T, eps^2 T ...
std::vector<double> geometric_times(double first_interval, double eps, std::size_t n) {
  std::vector<double> times{0.1};
  double interval = first_interval;
  for (std::size_t k = 1; k < n; ++k, interval *= eps) times.push_back(times.back() + interval);
  return times;
}

std::size_t n_clean(const RestitutionSamples& samples) {
  return static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.flags.empty(); }));
}

TEST(Restitution, IsTheRatioOfNeighbouringIntervals) {
  const auto r = restitution_samples(onsets_at(geometric_times(0.2, 0.9, 6)), {});
  ASSERT_EQ(r.samples.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(r.samples[k].eps, 0.9, 1e-12);
    EXPECT_NEAR(r.samples[k].v_mps, 0.5 * 9.81 * 0.2 * std::pow(0.9, k), 1e-12);
    EXPECT_EQ(r.samples[k].impact, static_cast<std::int64_t>(k) + 1);
  }
}

TEST(Restitution, PropagatesTimingErrorsToFirstOrder) {
  // the spread over many noisy copies is what sigma_eps says; 4000 copies: 1.1 % standard error of a spread
  const auto truth = geometric_times(0.05, 0.95, 3);
  const double sigma[3] = {2e-5, 5e-5, 3e-5};
  double sum = 0.0, sum2 = 0.0, sum_v2 = 0.0, stated = 0.0, stated_v = 0.0;
  constexpr int kCopies = 4000;
  for (int i = 0; i < kCopies; ++i) {
    Random random(5, RandomStream::test, static_cast<std::uint64_t>(i));
    auto onsets = onsets_at(truth);
    for (int k = 0; k < 3; ++k) {
      onsets[k].t_s += sigma[k] * random.normal();
      onsets[k].sigma_t_s = sigma[k];
    }
    const auto s = restitution_samples(onsets, {}).samples.at(0);
    sum += s.eps - 0.95;
    sum2 += std::pow(s.eps - 0.95, 2);
    sum_v2 += std::pow(s.v_mps - 0.5 * 9.81 * 0.05, 2);
    stated = *s.sigma_eps;
    stated_v = *s.sigma_v_mps;
  }
  EXPECT_NEAR(std::sqrt(sum2 / kCopies) / stated, 1.0, 0.045);  // 4 standard errors
  EXPECT_NEAR(std::sqrt(sum_v2 / kCopies) / stated_v, 1.0, 0.045);
  EXPECT_LT(std::abs(sum / kCopies), 4.0 * stated / std::sqrt(kCopies));
}

TEST(Restitution, KeepsDropsApart) {
  auto onsets = onsets_at({0.1, 0.3, 0.48});
  const auto second = onsets_at({2.1, 2.3, 2.48}, 1);
  onsets.insert(onsets.end(), second.begin(), second.end());
  const auto r = restitution_samples(onsets, {});
  EXPECT_EQ(r.counts.n_drops, 2u);
  EXPECT_EQ(r.samples.size(), 2u);
}

TEST(Restitution, UsesOnsetsOfKnownErrorWhateverTheirFlags) {
  auto onsets = onsets_at(geometric_times(0.2, 0.9, 12));
  onsets[5].flags = {Flag::clipped, Flag::doubtful};
  onsets[5].sigma_t_s = 1e-3;
  onsets[1].flags = {Flag::overlap};
  onsets[9].flags = Flags::from_text("a_word_of_somebody_else");
  const auto r = restitution_samples(onsets, {});
  ASSERT_EQ(n_clean(r.samples), 10u);
  EXPECT_TRUE(r.counts.breaks.empty());
  for (std::size_t k = 0; k < 10; ++k) {
    const bool uses_it = k >= 3 && k <= 5;
    EXPECT_EQ(*r.samples[k].sigma_eps > 1e-3, uses_it) << k;
  }
}

TEST(Restitution, BreaksTheChainAtADoubtfulOnsetOfUnknownErrorAndAtOneThatIsLessLikelyThanNotTheBalls) {
  auto onsets = onsets_at(geometric_times(0.2, 0.9, 12));
  onsets[5].flags = {Flag::clipped, Flag::doubtful};
  onsets[5].sigma_t_s.reset();
  const auto r = restitution_samples(onsets, {});
  // of 10 samples the three that use onset 5 are gone; a flag that does not touch the time breaks nothing
  ASSERT_EQ(r.samples.size(), 7u);
  EXPECT_EQ(n_clean(r.samples), 7u);
  for (const auto& s : r.samples) EXPECT_NEAR(s.eps, 0.9, 1e-12);
  EXPECT_EQ(r.counts.breaks.at(Flag::doubtful), 1u);
  for (const Flag flag : {Flag::improbable, Flag::inferred}) {
    onsets = onsets_at(geometric_times(0.2, 0.9, 12));
    onsets[0].flags = {Flag::doubtful, flag};
    onsets[11].flags = {flag};
    const auto inner = restitution_samples(onsets, {});
    ASSERT_EQ(inner.samples.size(), 8u);
    EXPECT_EQ(inner.samples.front().impact, 2);
    EXPECT_EQ(inner.samples.back().impact, 9);
    EXPECT_EQ(inner.counts.breaks.at(flag), 2u);
  }
}

TEST(Restitution, FlagsAMissedImpact) {
  auto times = geometric_times(0.2, 0.95, 30);
  times.erase(times.begin() + 12);
  const auto r = restitution_samples(onsets_at(times), {});
  ASSERT_EQ(r.samples.size(), 27u);
  // the two samples that use the doubled interval, and only they
  EXPECT_EQ(n_clean(r.samples), 25u);
  EXPECT_EQ(r.counts.breaks.at(Flag::missing_impact), 1u);
  for (const auto& s : r.samples) {
    if (s.flags.empty()) {
      EXPECT_NEAR(s.eps, 0.95, 1e-12);
    }
  }
}

TEST(Restitution, BreaksWhereTheDetectorLeftAGapInTheNumbers) {
  auto onsets = onsets_at(geometric_times(0.2, 0.95, 30));
  onsets.erase(onsets.begin() + 12);
  const auto r = restitution_samples(onsets, {});
  EXPECT_EQ(r.samples.size(), 25u);
  for (const auto& s : r.samples) EXPECT_NEAR(s.eps, 0.95, 1e-12);
}

TEST(Restitution, TakesASteepLawForNoMissedImpacts) {
  for (const double exponent : {-0.15, -0.25, -0.35, 0.2}) {
    std::vector<double> times{0.0};
    double interval_s = 0.5;  // 2.45 m/s
    for (int k = 0; k < 8; ++k) {
      times.push_back(times.back() + interval_s);
      interval_s *= 0.7 * std::pow(0.5 * 9.81 * interval_s, exponent);
    }
    EXPECT_EQ(n_clean(restitution_samples(onsets_at(times), {}).samples), 7u) << exponent;
  }
}

TEST(Restitution, FlagsAnInventedImpactWhereverItSplitsTheFlight) {
  for (const double fraction : {0.03, 0.3, 0.5, 0.6, 0.65, 0.7, 0.8, 0.97}) {
    auto times = geometric_times(0.2, 0.95, 30);
    times.insert(times.begin() + 13, times[12] + fraction * (times[13] - times[12]));
    const auto r = restitution_samples(onsets_at(times), {});
    EXPECT_EQ(r.counts.breaks.at(Flag::extra_impact), 1u) << fraction;
    EXPECT_GE(n_clean(r.samples), 24u) << fraction;
    for (const auto& s : r.samples) {
      if (s.flags.empty()) {
        EXPECT_NEAR(s.eps, 0.95, 1e-12) << fraction << " " << s.impact;
      }
    }
  }
}

TEST(Restitution, ARattleThatFollowsTheBouncesIsNoBounces) {
  std::vector<double> times = geometric_times(0.25, 0.88, 20);
  for (int k = 0; k < 12; ++k) times.push_back(times.back() + (k % 2 == 0 ? 0.0085 : 0.0091));
  const auto r = restitution_samples(onsets_at(times), {});
  EXPECT_EQ(n_clean(r.samples), 17u);  // the last of the 18 has the rattle for its second interval
  for (std::size_t k = 17; k < r.samples.size(); ++k) EXPECT_FALSE(r.samples[k].flags.empty()) << k;
}

TEST(Restitution, LeavesSigmaAbsentWhereATimeHasNone) {
  auto onsets = onsets_at(geometric_times(0.2, 0.9, 6));
  onsets[2].sigma_t_s.reset();
  const auto r = restitution_samples(onsets, {});
  EXPECT_FALSE(r.samples[0].sigma_eps);
  EXPECT_TRUE(r.samples[0].sigma_v_mps);
  EXPECT_TRUE(r.samples[3].sigma_eps);
}

TEST(Restitution, RejectsBadGravityAndUnsortedTimes) {
  RestitutionConfig weightless;
  weightless.gravity_mps2 = 0.0;
  EXPECT_THROW(restitution_samples(onsets_at({0.1, 0.2, 0.3}), weightless), InvalidArgument);
  EXPECT_THROW(restitution_samples(onsets_at({0.1, 0.3, 0.2}), {}), InvalidArgument);
  EXPECT_THROW(restitution_samples(onsets_at({0.1, NAN, 0.3}), {}), InvalidArgument);
}

TEST(Restitution, RefusesOptionsThatNobodyCouldType) {
  const auto refused = [](auto set) {
    RestitutionConfig config;
    set(config);
    return test::refusal<InvalidArgument>([&] { restitution_samples({}, config); });
  };
  using C = RestitutionConfig;
  EXPECT_THAT(refused([](C& c) { c.gravity_mps2 = NAN; }), StartsWith("gravity: 'nan' must be"));
  EXPECT_THAT(refused([](C& c) { c.air_kgpm3 = -1.0; }), StartsWith("air: '-1' must be"));
  EXPECT_THAT(refused([](C& c) { c.wave_speed_mps = 0.0; }), StartsWith("wave_speed: '0' must be"));
  EXPECT_THAT(refused([](C& c) { c.sigma_t_s = -1e-6; }), StartsWith("sigma_t: "));
  EXPECT_THAT(refused([](C& c) { c.drop_height_m = 0.0; }), StartsWith("drop_height: '0' stands for"));
  EXPECT_THAT(refused([](C& c) { c.ball = Ball{.radius_m = NAN}; }), StartsWith("radius of the ball"));
}

TEST(Restitution, RefusesImpactsWithoutNumbers) {
  Onsets onsets = onsets_at({0.1, 0.2, 0.3, 0.4});
  for (Onset& onset : onsets) onset.impact = 0;
  EXPECT_EQ(test::refusal<InvalidArgument>([&] { restitution_samples(onsets, {}); }),
            "drop 0: impact 0 follows impact 0; number the impacts of a drop in their order, 0, 1, 2 ...");
}

TEST(Restitution, OfFewerThanThreeOnsetsIsEmpty) {
  EXPECT_TRUE(restitution_samples({}, {}).samples.empty());
  EXPECT_TRUE(restitution_samples(onsets_at({0.1, 0.2}), {}).samples.empty());
}

/// Three recordings of a few drops each; the first comes back at the end. With flags, gaps and errors.
Onsets many_onsets() {
  testing::SyntheticRun run;
  run.n_drops = 4;
  const Onsets drops = synthetic_onsets(run);
  Onsets all;
  for (const char* recording : {"a.wav", "b.wav", "c.wav", "a.wav"})
    for (Onset onset : drops) {
      onset.recording = recording;
      if (onset.impact == 7 && onset.drop == 1) continue;
      if (onset.impact == 12) onset.flags.add(Flag::inferred);
      all.push_back(onset);
    }
  return all;
}

/// All digits of all columns.
std::string text_of(const RestitutionSamples& samples) {
  std::ostringstream text;
  write_csv(text, to_table(samples));
  return text.str();
}

void expect_the_same_in_pieces(const RestitutionConfig& config) {
  const Onsets onsets = many_onsets();
  const Restitution whole = restitution_samples(onsets, config);
  ASSERT_GT(whole.samples.size(), 100U);
  for (const std::size_t piece : {1U, 13U, 1000U}) {
    RestitutionInPieces pieces(config);
    RestitutionSamples samples;
    const auto take = [&](RestitutionSamples more) {
      std::move(more.begin(), more.end(), std::back_inserter(samples));
    };
    for (std::size_t first = 0; first < onsets.size(); first += piece) {
      const auto begin = onsets.begin() + static_cast<std::ptrdiff_t>(first);
      take(pieces.add(Onsets(begin, begin + static_cast<std::ptrdiff_t>(std::min(piece, onsets.size() - first)))));
    }
    take(pieces.finish());
    EXPECT_TRUE(text_of(samples) == text_of(whole.samples)) << piece;
    const RestitutionCounts &a = pieces.counts(), &b = whole.counts;
    EXPECT_EQ(std::tie(a.n_onsets, a.n_drops, a.n_samples, a.n_flagged, a.breaks),
              std::tie(b.n_onsets, b.n_drops, b.n_samples, b.n_flagged, b.breaks));
  }
}

TEST(RestitutionInPieces, GivesTheSameSamplesAndCountsHoweverTheOnsetsAreCut) {
  expect_the_same_in_pieces({});
  RestitutionConfig corrected;
  corrected.ball = ball_from_text("steel:6mm");
  corrected.plate = plate_from_text("glass");
  expect_the_same_in_pieces(corrected);
}

RestitutionSample sample(const std::string& recording, std::int64_t drop, std::int64_t impact, double v_mps) {
  RestitutionSample s;
  s.recording = recording;
  s.drop = drop;
  s.impact = impact;
  s.v_mps = v_mps;
  s.eps = 0.8;
  return s;
}

TEST(PredictIntervals, AreTheFlightBeforeTimesTheCoefficientOfRestitutionOfThatDropOnly) {
  RestitutionSamples samples{sample("a.wav", 0, 1, 1.0), sample("a.wav", 1, 1, 1.0), sample("a.wav", 1, 2, 0.5),
                             sample("b.wav", 1, 1, 1.0)};
  samples[2].sigma_eps = 1e-3;
  const auto intervals = predict_intervals(samples, "a.wav", 1, ConstantLaw{0.9}, 10.0);
  ASSERT_EQ(intervals.size(), 2u);
  EXPECT_EQ(intervals[1].impact, 2);
  // 2 v / g = 0.1 s; products of two doubles
  EXPECT_DOUBLE_EQ(intervals[1].measured_s, 0.08);
  EXPECT_DOUBLE_EQ(*intervals[1].predicted_s, 0.09);
  EXPECT_DOUBLE_EQ(*intervals[1].sigma_s, 1e-4);
  EXPECT_FALSE(intervals[0].sigma_s);
}

TEST(PredictIntervals, PredictNothingWithoutALaw) {
  const auto intervals = predict_intervals({sample("a.wav", 0, 1, 1.0)}, "a.wav", 0, std::nullopt, 9.81);
  ASSERT_EQ(intervals.size(), 1u);
  EXPECT_FALSE(intervals[0].predicted_s);
}

TEST(Restitution, AMissedImpactIsFlaggedAndTheScatterOfAStopWatchIsNot) {
  const auto n_flagged = [](std::vector<double> times, double error_s, bool error_is_known, std::uint64_t number) {
    Random random(65, RandomStream::test, number);
    for (double& t_s : times) t_s += error_s * random.normal();
    Onsets onsets = onsets_at(times);
    for (Onset& onset : onsets) onset.sigma_t_s = 0.003, onset.errors = error_is_known ? "" : kOfDigits;
    const RestitutionSamples samples = restitution_samples(onsets, {}).samples;
    return samples.size() - n_clean(samples);
  };
  const std::vector<double> heard = geometric_times(0.8, 0.9, 10);
  std::vector<double> missed = heard;
  missed.erase(missed.begin() + 5);
  std::size_t by_hand = 0, as_if_exact = 0;
  for (std::uint64_t number = 0; number < 40; ++number) {
    for (const bool error_is_known : {true, false}) EXPECT_EQ(n_flagged(missed, 1e-4, error_is_known, number), 2U);
    by_hand += n_flagged(heard, 0.05, false, number);
    as_if_exact += n_flagged(heard, 0.05, true, number);
  }
  EXPECT_GT(as_if_exact, 20U);  // what is told apart is not told apart by being rare
  EXPECT_LE(by_hand, as_if_exact / 10);
}

}  // namespace
}  // namespace bouncelab::fit
