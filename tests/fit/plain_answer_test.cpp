// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/plain_answer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/json.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

using ::testing::HasSubstr;

constexpr double kG = 9.81;  // kDefaultGravity_mps2, with which samples are made and read

/// Onsets of balls dropped from a height, eps the same at every impact; the first fall begins at begin_s.
Onsets dropped(double height_m, double eps, std::size_t n_impacts, double begin_s, std::int64_t drop = 0) {
  Onsets onsets;
  double t_s = begin_s + std::sqrt(2.0 * height_m / kG), v_mps = std::sqrt(2.0 * kG * height_m);
  for (std::size_t k = 0; k < n_impacts; ++k) {
    Onset onset;
    onset.recording = "ball.wav";
    onset.drop = drop;
    onset.impact = static_cast<std::int64_t>(k);
    onset.t_s = t_s;
    onset.sigma_t_s = 1e-5;
    onsets.push_back(onset);
    v_mps *= eps;
    t_s += 2.0 * v_mps / kG;
  }
  return onsets;
}

TEST(DropsSeen, TellTheHeightOfTheReleaseTheImpactsAndHowLongTheyLast) {
  const Onsets onsets = dropped(0.12, 0.9, 20, 2.0);
  const DropsSeen seen = drops_seen(restitution_samples(onsets, {}).samples);
  EXPECT_EQ(seen.n_drops, 1u);
  EXPECT_EQ(seen.n_impacts, 20u);
  ASSERT_TRUE(seen.drop_height_m && seen.duration_s);
  EXPECT_NEAR(*seen.drop_height_m, 0.12, 1e-9);  // exact but for rounding: eps is the same at every impact
  EXPECT_NEAR(*seen.duration_s, onsets.back().t_s - onsets.front().t_s, 1e-9);
}

TEST(DropsSeen, KnowNoHeightWhereTheRecordingBeginsTooLateToTellWhichImpactIsTheFirst) {
  // released at the first sample: a bounce before the first impact seen would lie before the recording
  EXPECT_FALSE(drops_seen(restitution_samples(dropped(0.12, 0.9, 20, 0.0), {}).samples).drop_height_m);
  // the first impact was not detected
  RestitutionSamples late = restitution_samples(dropped(0.12, 0.9, 20, 2.0), {}).samples;
  late.erase(late.begin());
  EXPECT_FALSE(drops_seen(late).drop_height_m);
  EXPECT_EQ(drops_seen(late).n_impacts, 19u);
}

TEST(DropsSeen, OfSeveralDropsTakeTheMedianHeightInAnyOrderOfTheSamples) {
  RestitutionSamples samples;
  for (const double height_m : {0.3, 0.1, 0.2}) {
    const auto drop = static_cast<std::int64_t>(std::lround(10 * height_m));
    const auto of_one = restitution_samples(dropped(height_m, 0.8, 9, 2.0 + 10.0 * height_m, drop), {}).samples;
    samples.insert(samples.begin(), of_one.rbegin(), of_one.rend());
  }
  const DropsSeen seen = drops_seen(samples);
  EXPECT_EQ(seen.n_heights, 3u);
  EXPECT_NEAR(seen.drop_height_m.value_or(0.0), 0.2, 1e-9);
  EXPECT_EQ(seen.n_impacts, 27u);
}

TEST(DropsSeen, OfATableOfSpeedsAndEpsAloneKnowNeitherImpactsNorTimes) {
  RestitutionSamples samples(10);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].impact = static_cast<std::int64_t>(k);  // as such a table is read
    samples[k].v_mps = 1.0 - 0.01 * static_cast<double>(k);
    samples[k].eps = 0.9;
  }
  const DropsSeen seen = drops_seen(samples);
  EXPECT_FALSE(seen.n_impacts || seen.duration_s || seen.drop_height_m);
}

TEST(PlainAnswer, SaysEpsAtTheMiddleSpeedWhereItChangesAndWhatEnergyIsLost) {
  testing::SyntheticRun run;
  run.timing_sigma_s = 3e-6;
  const auto result = fit_all(restitution_samples(testing::synthetic_onsets(run), {}).samples, {});
  const PlainAnswer& answer = result.answer;
  ASSERT_TRUE(answer.at);
  const NodeEstimate& middle = result.law.nodes.at(1);
  EXPECT_EQ(answer.at->v_mps, middle.v_mps);
  EXPECT_EQ(answer.at->eps.value, middle.eps.value);
  EXPECT_DOUBLE_EQ(answer.at->energy_lost, 1.0 - middle.eps.value * middle.eps.value);
  ASSERT_EQ(answer.elsewhere.size(), 2u);  // a law that falls by .007 between the nodes, known to some 1e-5
  EXPECT_EQ(answer.elsewhere[0].v_mps, result.law.nodes.back().v_mps);
  EXPECT_THAT(answer.sentences.at(0), HasSubstr("ε = 0.97"));
  EXPECT_THAT(answer.sentences.at(0), HasSubstr(" m/s; it falls to "));
  EXPECT_THAT(answer.sentences.at(0), HasSubstr(" and rises to "));
  EXPECT_THAT(answer.sentences.at(1), HasSubstr(" % of the energy"));
  EXPECT_THAT(answer.sentences.at(2), HasSubstr("3880 impacts in 40 drops"));
  for (const std::string& sentence : answer.sentences) EXPECT_EQ(sentence.find("A2"), std::string::npos) << sentence;

  const auto json = nlohmann::json::parse(to_json(result)).at("answer");
  EXPECT_EQ(json.at("at").at("eps"), middle.eps.value);
  EXPECT_EQ(json.at("seen").at("n_impacts"), 3880);
  EXPECT_EQ(json.at("sentences").size(), answer.sentences.size());
}

TEST(PlainAnswer, HasOneValueWhereThereIsTooLittleForACurve) {
  RestitutionSamples samples = restitution_samples(dropped(0.2, 0.8, 6, 2.0), {}).samples;  // four samples
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].eps += k % 2 == 0 ? 0.004 : -0.004;
  const auto result = fit_all(samples, {});
  ASSERT_TRUE(result.answer.at) << result.law.message;
  EXPECT_TRUE(result.answer.one_value);
  EXPECT_TRUE(result.answer.elsewhere.empty());
  EXPECT_THAT(result.answer.sentences.at(0), HasSubstr("one value for all speeds"));
}

TEST(PlainAnswer, SaysWhatIsMissingWhereThereIsNothing) {
  EXPECT_THAT(fit_all({}, {}).answer.sentences.at(0), HasSubstr("ε is not known"));
  const auto one = fit_all(restitution_samples(dropped(0.2, 0.8, 3, 2.0), {}).samples, {});
  EXPECT_FALSE(one.answer.at);
  EXPECT_THAT(one.answer.sentences.at(0), HasSubstr("ε is about 0.80, from one bounce alone"));
}

TEST(PlainAnswer, OfUnlikeRecordingsNamesTheirRangeAndNoCommonValue) {
  testing::SyntheticRun run;
  RestitutionSamples samples = testing::independent_samples(run, 300, 0.2, 1.4, 1e-4);
  for (RestitutionSample& s : samples) s.recording = "here/a.wav";
  const std::size_t n = samples.size();
  for (std::size_t k = 0; k < n; ++k) {
    samples.push_back(samples[k]);
    samples.back().recording = "there/b.wav";
    samples.back().eps -= 0.05;  // a hundred times its scatter
  }
  const PlainAnswer answer = fit_all(samples, {}).answer;
  EXPECT_FALSE(answer.at);
  ASSERT_EQ(answer.recordings.size(), 2u);
  ASSERT_TRUE(answer.recordings[0].at && answer.recordings[1].at);
  EXPECT_EQ(answer.recordings[0].at->v_mps, answer.recordings[1].at->v_mps);
  // the same scatter about both: the difference is what was taken off, but for the errors of the two fits
  EXPECT_NEAR(answer.recordings[0].at->eps.value - answer.recordings[1].at->eps.value, 0.05, 1e-3);
  EXPECT_THAT(answer.sentences.at(0), HasSubstr("(b.wav, "));
  EXPECT_THAT(answer.sentences.at(0), ::testing::Not(HasSubstr("there/")));
}

}  // namespace
}  // namespace bouncelab::fit
