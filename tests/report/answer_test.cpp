// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "dropped.hpp"
#include "synthetic_samples.hpp"
#include "words.hpp"

namespace bouncelab::report {
namespace {

using namespace fit;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

FitInWords told(const RestitutionSamples& samples) { return in_words(fit_all(samples, {}), samples); }

/// Onsets of a ball, eps the same at every impact; the fall begins at begin_s.
Onsets dropped(double height_m, double eps, std::size_t n_impacts, double begin_s) {
  return onsets_of(
      {.height_m = height_m, .eps = [eps](int) { return eps; }, .n_impacts = n_impacts, .begin_s = begin_s});
}

RestitutionSamples in_no_air(const Onsets& onsets) { return restitution_samples(onsets, no_air()).samples; }

TEST(PlainAnswer, SaysEpsAtTheMiddleSpeedWhereItChangesAndWhatEnergyIsLost) {
  bouncelab::testing::SyntheticRun run;
  run.timing_sigma_s = 3e-6;
  const RestitutionSamples samples = in_no_air(bouncelab::testing::synthetic_onsets(run));
  const auto result = fit_all(samples, {});
  const FitInWords words = in_words(result, samples);
  const PlainAnswer& answer = words.answer;
  ASSERT_TRUE(answer.at);
  const CurveNode& middle = result.curve->nodes.at(1);
  EXPECT_EQ(answer.at->v_mps, middle.v_mps);
  EXPECT_EQ(answer.at->eps.value, middle.eps.value);
  // of <eps^2>, which eps is the root of: one number, whatever the scatter
  double kept = 0.0, n = 0.0;
  for (const RestitutionSample& s : samples)
    if (std::abs(std::log(s.v_mps / middle.v_mps)) < 0.1) kept += s.eps * s.eps, n += 1.0;
  EXPECT_DOUBLE_EQ(answer.at->energy_lost, 1.0 - middle.eps.value * middle.eps.value);
  EXPECT_NEAR(answer.at->energy_lost, 1.0 - kept / n, 2e-4);  // of some 400 that scatter by 1.6e-3 in eps^2: 8e-5
  ASSERT_EQ(answer.elsewhere.size(), 2u);  // a law that falls by .007 between the nodes, known to some 1e-5
  EXPECT_EQ(answer.elsewhere[0].v_mps, result.curve->points.back().x);
  EXPECT_EQ(answer.elsewhere[1].v_mps, result.curve->points.front().x);
  EXPECT_THAT(answer.sentences.at(0), HasSubstr("ε = 0.980"));
  EXPECT_THAT(answer.sentences.at(0), HasSubstr(" m/s; it falls to "));
  EXPECT_THAT(answer.sentences.at(0), HasSubstr(" and rises to "));
  EXPECT_THAT(answer.sentences.at(1), HasSubstr(" % of the energy"));
  EXPECT_THAT(answer.sentences.at(2), HasSubstr("3880 impacts in 40 drops"));
  for (const std::string& sentence : answer.sentences) EXPECT_EQ(sentence.find("A2"), std::string::npos) << sentence;

  const auto json = nlohmann::json::parse(json_text(object_of(result, words))).at("answer");
  EXPECT_EQ(json.at("at").at("eps"), middle.eps.value);
  EXPECT_EQ(json.at("seen").at("n_impacts"), 3880);
  EXPECT_EQ(json.at("sentences").size(), answer.sentences.size());
}

TEST(PlainAnswer, SeesNoChangeWhereThereIsTooLittleForACurve) {
  RestitutionSamples samples = in_no_air(dropped(0.2, 0.8, 6, 2.0));  // four samples
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].eps += k % 2 == 0 ? 0.004 : -0.004;
  const PlainAnswer answer = told(samples).answer;
  ASSERT_TRUE(answer.at);
  EXPECT_TRUE(answer.elsewhere.empty());
  EXPECT_THAT(answer.sentences.at(0), HasSubstr("no change with the speed is seen"));
}

TEST(PlainAnswer, ABallThatKeepsMoreThanItsRulesAllowIsDoubted) {
  const auto said = [](double eps) {  // from 2 m/s on and above, beyond what the rule's test tells
    RestitutionSamples samples;
    for (int k = 0; k < 6; ++k) {
      RestitutionSample s;
      s.impact = k + 1, s.v_mps = 4.5 - 0.1 * k, s.eps = eps + (k % 2 == 0 ? 0.001 : -0.001), s.sigma_eps = 1e-3;
      s.conditions.ball = ball_from_text("table-tennis");
      samples.push_back(s);
    }
    std::string all;
    for (const std::string& sentence : told(samples).answer.sentences) all += sentence + " ";
    return all;
  };
  // sqrt(260 mm/305 mm) = 0.923
  EXPECT_THAT(said(0.96), HasSubstr("ε is above what the rule (ITTF) allows of such a ball, 0.92 at 2.4 m/s on a block "
                                    "of steel. Is it another ball, or a speed that is wrong?"));
  EXPECT_THAT(said(0.90), ::testing::Not(HasSubstr("rule")));
}

TEST(Notes, NameTheirRecordingOnce) {
  const Note note{NoteKind::recording_left_out, {}, "a.wav: the file is empty", "a.wav"};
  EXPECT_EQ(as_sentence(note), "a.wav: the file is empty; left out.");
  EXPECT_EQ(texts_of({note}).front(), "a.wav: the file is empty; left out");
}

TEST(PlainAnswer, SaysWhatIsMissingWhereThereIsNothing) {
  EXPECT_THAT(told({}).answer.sentences.at(0), HasSubstr("ε is not known"));
  // one bounce: with the scatter that balls have
  const PlainAnswer one = told(in_no_air(dropped(0.2, 0.8, 3, 2.0))).answer;
  ASSERT_TRUE(one.at);
  EXPECT_TRUE(one.one_value);
  EXPECT_NEAR(one.at->eps.value, std::hypot(0.8, 0.005), 1e-5);  // root mean square, by the scatter that balls have
  EXPECT_GT(*one.at->eps.se, 0.004);
  EXPECT_THAT(one.sentences.at(0), HasSubstr("ε = 0.80"));
}

TEST(PlainAnswer, OfUnlikeRecordingsNamesTheirRangeAndNoCommonValue) {
  bouncelab::testing::SyntheticRun run;
  RestitutionSamples samples = bouncelab::testing::independent_samples(run, 300, 0.2, 1.4, 1e-4);
  for (RestitutionSample& s : samples) s.recording = "here/a.wav";
  const std::size_t n = samples.size();
  for (std::size_t k = 0; k < n; ++k) {
    samples.push_back(samples[k]);
    samples.back().recording = "there/b.wav";
    samples.back().eps -= 0.05;  // a hundred times its scatter
  }
  const PlainAnswer answer = told(samples).answer;
  EXPECT_FALSE(answer.at);
  ASSERT_EQ(answer.recordings.size(), 2u);
  ASSERT_TRUE(answer.recordings[0].at && answer.recordings[1].at);
  EXPECT_EQ(answer.recordings[0].at->v_mps, answer.recordings[1].at->v_mps);
  // the same scatter about both: the difference is what was taken off, but for the errors of the two fits
  EXPECT_NEAR(answer.recordings[0].at->eps.value - answer.recordings[1].at->eps.value, 0.05, 1e-3);
  EXPECT_THAT(answer.sentences.at(0), HasSubstr("(b.wav)"));
  EXPECT_THAT(answer.sentences.at(0), Not(HasSubstr("there/")));
}

/// Three recordings of one ball, of so many samples each.
RestitutionSamples three_recordings(std::size_t n_each) {
  RestitutionSamples samples = bouncelab::testing::independent_samples({}, 3 * n_each, 0.2, 1.4, 1e-4);
  for (std::size_t k = 0; k < samples.size(); ++k)
    samples[k].recording = std::string(1, static_cast<char>('a' + k % 3));
  return samples;
}

TEST(PlainAnswer, OfRecordingsThatAgreeIsOneAndARowForEach) {
  const RestitutionSamples samples = three_recordings(60);
  const PlainAnswer answer = told(samples).answer;
  EXPECT_TRUE(answer.at);
  ASSERT_EQ(answer.recordings.size(), 3u);
  EXPECT_THAT(in_words(answer.recordings[1]), ::testing::StartsWith("b: ε = 0.97"));
}

TEST(PlainAnswer, OfRecordingsThatCannotBeComparedIsPooledWhereAskedFor) {
  const RestitutionSamples samples = three_recordings(2);
  const FitResult result = fit_all(samples, {});
  const PlainAnswer apart = in_words(result, samples).answer;
  EXPECT_FALSE(apart.at);
  EXPECT_THAT(apart.sentences.at(0), HasSubstr("agree is not known"));
  EXPECT_THAT(apart.sentences.at(0), HasSubstr("--pool"));
  FitConfig config;
  config.pool = true;
  EXPECT_TRUE(in_words(fit_all(samples, config), samples).answer.at);
}

TEST(PlainAnswer, OfUnlikeRecordingsIsPooledWhereAskedForAndTheDoubtSaysThatTheyDoNotAgree) {
  RestitutionSamples samples = three_recordings(60);
  for (RestitutionSample& s : samples)
    if (s.recording == "b") s.eps -= 0.05;  // a hundred times its scatter
  const FitResult result = fit_all(samples, {});
  FitConfig config;
  config.pool = true;
  FitInWords apart = in_words(result, samples), pooled = in_words(fit_all(samples, config), samples);
  take(apart.notes, apart);
  take(pooled.notes, pooled);
  EXPECT_FALSE(apart.answer.at);
  EXPECT_THAT(apart.answer.doubt, Not(HasSubstr("agree")));  // the answer says it
  EXPECT_TRUE(pooled.answer.at);
  EXPECT_THAT(pooled.answer.doubt, HasSubstr("The 3 recordings differ by more than chance"));
}

/// Names of the causes that are seen, the largest first.
std::vector<std::string> seen_causes(const FitInWords& words) {
  std::vector<std::string> names;
  EXPECT_EQ(words.causes.size(), 3u);
  for (const Cause& cause : words.causes)
    if (cause.is_seen) names.push_back(cause.name);
  return names;
}

TEST(Causes, AreMostlyTheSpeedWhereTheLawFallsByMoreThanTheBouncesScatter) {
  bouncelab::testing::SyntheticRun run;  // eps falls by .007, the scatter at 0.6 m/s is .0008
  run.n_drops = 3;
  run.timing_sigma_s = 1e-6;
  const RestitutionSamples samples = in_no_air(bouncelab::testing::synthetic_onsets(run));
  const FitInWords words = told(samples);
  EXPECT_THAT(seen_causes(words), ::testing::ElementsAre("speed", "roughness"));
  EXPECT_THAT(words.causes[0].sentence, ::testing::StartsWith("Mostly the speed"));
  const auto [slowest, fastest] = std::minmax_element(samples.begin(), samples.end(),
                                                      [](const auto& a, const auto& b) { return a.v_mps < b.v_mps; });
  const auto rms = [&](double v_mps) {
    const double below = mean_below(run, v_mps), above = mean_above(run, v_mps);
    return std::hypot(restitution(run.law, v_mps) + above - below, std::hypot(below, above));
  };
  // three drops: either end to some 2e-4
  EXPECT_NEAR(words.causes[0].size.value_or(0.0), rms(slowest->v_mps) - rms(fastest->v_mps), 8e-4);
}

TEST(Causes, SayOfTheSpeedWhatTheHeadlineSaysWhereOneEndAloneIsSeenToDiffer) {
  FitResult result;
  result.curve.emplace();
  const auto of = [](double v_mps, double eps) {
    SpeedAndRestitution at;
    at.v_mps = v_mps, at.eps.value = eps;
    return at;
  };
  for (const auto& [v_mps, eps] : {std::pair{0.1, 0.93}, {0.5, 0.91}, {3.0, 0.92}}) {
    result.curve->points.emplace_back();
    result.curve->points.back().x = v_mps, result.curve->points.back().y = eps;
  }
  PlainAnswer answer;
  answer.at = of(0.5, 0.91);
  answer.elsewhere = {of(3.0, 0.92)};
  const Cause speed = causes_of(result, answer, {}).at(0);
  EXPECT_EQ(speed.sentence, "Mostly the speed: ε rises by 0.010 between 0.5 m/s and 3 m/s.");
}

TEST(Causes, AreMostlyTheRoughnessWhereEpsIsOneValueThatScatters) {
  bouncelab::testing::SyntheticRun run;
  run.law = ConstantLaw{0.9};
  run.below_at_1mps = run.above_at_1mps = 4e-3;
  const FitInWords words = told(bouncelab::testing::independent_samples(run, 200, 0.3, 1.3, 1e-4));
  EXPECT_EQ(words.causes.at(0).name, "roughness");
  EXPECT_THAT(words.causes[0].sentence, ::testing::StartsWith("Mostly the roughness"));
  EXPECT_THAT(words.causes[1].sentence + words.causes[2].sentence, HasSubstr("No effect of the speed is seen"));
}

TEST(Causes, DoNotNameTheRoughnessWhereErrorsOfTheTimesExplainTheScatter) {
  bouncelab::testing::SyntheticRun run;
  run.law = ConstantLaw{0.9};
  run.below_at_1mps = run.above_at_1mps = 1e-5;
  const FitInWords words = told(bouncelab::testing::independent_samples(run, 200, 0.3, 1.3, 2e-3));
  EXPECT_THAT(seen_causes(words), Not(Contains("roughness")));
}

TEST(Causes, AreMostlyTheAirOfATableTennisBallOfOneEps) {
  RestitutionConfig config;
  config.ball = ball_from_text("table-tennis");
  // intervals in vacuum, as if the drag were there: the effect is the ball's by its size and mass
  const FitInWords words = told(restitution_samples(dropped(0.3, 0.9, 20, 2.0), config).samples);
  ASSERT_EQ(words.causes.size(), 3u);
  const auto air =
      std::find_if(words.causes.begin(), words.causes.end(), [](const Cause& c) { return c.name == "air"; });
  EXPECT_TRUE(air->is_seen);
  // eps (1 + eps^2) kappa v^2 / (4 g), kappa .12 to .14 per m, v up to some 2 m/s: .005 to .02
  EXPECT_GT(air->size.value_or(0.0), 0.005);
  EXPECT_LT(air->size.value_or(0.0), 0.03);
  EXPECT_THAT(air->sentence, HasSubstr("taken out of the values here"));
}

TEST(Causes, OfTheAirAreNotKnownWithoutTheBall) {
  RestitutionSamples samples = restitution_samples(dropped(0.3, 0.9, 20, 2.0), {}).samples;
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].eps += k % 2 == 0 ? 0.004 : -0.004;  // no simulation's
  const FitInWords words = told(samples);
  EXPECT_THAT(seen_causes(words), Not(Contains("air")));
  EXPECT_THAT(words.causes.back().sentence + words.causes.at(1).sentence, HasSubstr("name the ball"));
}

TEST(FitInWords, AnswersTheFiveQuestionsOfAReader) {
  const FitInWords words = told(bouncelab::testing::independent_samples({}, 20000, 0.2, 1.4, 1e-4));
  ASSERT_EQ(words.findings.size(), 5u);
  const auto says = [&](std::size_t k, const char* part) {
    return words.findings[k].answer.find(part) != std::string::npos;
  };
  EXPECT_TRUE(says(0, "A2 = 0.0")) << words.findings[0].answer;
  EXPECT_TRUE(says(1, "95 % intervals") && says(1, "as the fit assumes")) << words.findings[1].answer;
  EXPECT_TRUE(says(2, "the ball itself") && says(2, "measuring the speeds")) << words.findings[2].answer;
  EXPECT_TRUE(says(3, "No: ") && says(3, "8 of 8") && says(3, "falling over rising at 0.7 m/s: "))
      << words.findings[3].answer;
  EXPECT_TRUE(says(4, "√⟨ε²⟩ = 0.9795") && says(4, "0.52 m/s")) << words.findings[4].answer;
}

TEST(FitInWords, HasAConstantOfDissipationWhereAViscoelasticBallExplainsTheCurveAndNoneWhereNot) {
  // the paper's law is of three constants: twenty thousand bounces see that one is too few, fifty do not
  const auto dependence = [](const RestitutionLaw& law, std::size_t n) {
    return told(bouncelab::testing::independent_samples({.law = law}, n, 0.2, 1.4, 1e-4)).findings.at(0).answer;
  };
  EXPECT_THAT(dependence(SeriesLaw{}, 20000), Not(HasSubstr("gamma = ")));
  EXPECT_THAT(dependence(SeriesLaw{}, 50), HasSubstr("gamma = 0.0"));
  EXPECT_THAT(dependence(ViscoelasticLaw{0.1}, 2000), HasSubstr("gamma = 0.1"));
}

TEST(FitInWords, WarnsOfFlagsThatNothingOfOursWrites) {
  RestitutionSamples samples = bouncelab::testing::independent_samples({}, 500, 0.2, 1.4, 0.0);
  samples[6].flags = Flags::from_text("missing_impact|other");
  samples[7].flags = Flags::from_text("a_word_of_somebody_else");
  EXPECT_THAT(texts_of(told(samples).notes, Severity::warning), Contains(HasSubstr("a_word_of_somebody_else")));
  ASSERT_FALSE(told({}).notes.empty());
  EXPECT_EQ(told({}).notes.front().kind, NoteKind::too_few_samples);
}

TEST(FitInWords, WarnsWhereErrorsCannotBeByDrop) {
  RestitutionSamples samples = bouncelab::testing::independent_samples({}, 400, 0.2, 1.4, 0.0);
  const auto in_drops = [&](auto drop_of) {
    for (std::size_t k = 0; k < samples.size(); ++k) samples[k].drop = static_cast<std::int64_t>(drop_of(k));
    return texts_of(told(samples).notes);
  };
  EXPECT_THAT(in_drops([](std::size_t k) { return k % 9; }),
              Contains(HasSubstr("9 drops: standard errors of constants")));
  EXPECT_THAT(in_drops([](std::size_t k) { return k < 14 ? k : 14; }),
              Contains(HasSubstr("nearly all that is known comes from one drop")));
  EXPECT_THAT(in_drops([](std::size_t k) { return k % 10; }), Not(Contains(HasSubstr("assume independent impacts"))));
}

TEST(Notes, OfEachKindHaveWordsThatTakeItsNumbers) {
  for (int k = 0; k <= static_cast<int>(NoteKind::detector_failed); ++k) {
    const Note note{static_cast<NoteKind>(k), {1.0, 2.0, 3.0, 4.0}, "SUBJECT"};
    const std::string words = in_words(note);
    EXPECT_FALSE(words.empty()) << to_string(note.kind);
    EXPECT_EQ(words.find_first_of("{}|"), std::string::npos) << words;
    EXPECT_NE(words.back(), '.') << words;
    EXPECT_EQ(as_sentence({note.kind, note.numbers, note.subject, "a.wav"}).rfind("a.wav: ", 0), 0u);
  }
  EXPECT_EQ(in_words({NoteKind::clipped, {3.0, 52.0}}), "3 of 52 impacts are clipped: record with less gain");
  EXPECT_EQ(in_words({NoteKind::outliers, {1.0}}).rfind("1 bounce is left out", 0), 0u);
  EXPECT_EQ(in_words({NoteKind::outliers, {2.0}}).rfind("2 bounces are left out", 0), 0u);
}

TEST(Notes, AreOrderedBySeverityAndKindAndStandOnce) {
  std::vector<Note> notes{{NoteKind::few_drops, {}, "2 drops"},
                          {NoteKind::lossy_coding, {}, "MP3"},
                          {NoteKind::no_ball_likely, {3.0, 1.0}},
                          {NoteKind::eps_impossible, {4.0, 28.0}},
                          {NoteKind::lossy_coding, {}, "MP3"}};
  order(notes);
  ASSERT_EQ(notes.size(), 4u);
  EXPECT_EQ(notes[0].kind, NoteKind::no_ball_likely);
  EXPECT_EQ(notes[1].kind, NoteKind::eps_impossible);
  EXPECT_EQ(notes[2].kind, NoteKind::lossy_coding);
  FitInWords words;
  words.answer.sentences = {"ε = 0.9 at 1 m/s."};
  take({notes.begin() + 1, notes.end()}, words);
  EXPECT_EQ(words.answer.doubt,
            "4 of 28 samples have ε below 0 or above 1; check the order of the times, the columns and their units.");
  take(notes, words);
  ASSERT_EQ(words.answer.sentences.size(), 1u);
  EXPECT_EQ(words.answer.sentences[0].rfind("No ε is stated: ", 0), 0u);
}

TEST(FitInWords, SaysFirstThatRecordingsDoNotAgreeAndWhichAreFurthestOff) {
  RestitutionSamples samples = bouncelab::testing::independent_samples({}, 200, 0.2, 1.4, 0.0);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].recording = k < 192 ? "a" : "b";
    if (k >= 192) samples[k].eps -= 0.2;
  }
  const std::vector<std::string> warnings = texts_of(told(samples).notes, Severity::warning);
  ASSERT_FALSE(warnings.empty());
  EXPECT_THAT(warnings.front(), HasSubstr("the 2 recordings differ by more than chance"));
  EXPECT_THAT(warnings.front(), HasSubstr("(b) to "));
  std::erase_if(samples, [n = 0](const RestitutionSample& s) mutable { return s.recording == "b" && ++n > 2; });
  EXPECT_THAT(in_words(fit_all(samples, {}).recordings), HasSubstr("cannot be compared"));
  EXPECT_EQ(in_words(fit::Recordings{}), "");
}

}  // namespace
}  // namespace bouncelab::report
