// SPDX-License-Identifier: GPL-3.0-or-later
// The fit with memory as users get it: within fit_all, as fit.json, as text, and as the roughness of a ball.
#include "bouncelab/fit/memory_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bouncelab/core/error.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"
#include "numerics/numerics.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::report {
using namespace fit;

namespace {

constexpr double kQ = 2e-5;

/// Ten drops of 50 impacts, without timing errors; speeds of no gravity, and so without drag.
RestitutionSamples drops(bool with_memory) {
  RestitutionSamples samples = testing::rough_drops({.n = 10, .impacts = 49, .q = kQ, .memory = with_memory}, 17);
  for (RestitutionSample& s : samples) s.conditions.gravity_mps2.reset();
  return samples;
}

FitConfig with_memory() {
  FitConfig config;
  config.memory = UseMemory::always;
  config.n_goodness = 0;
  return config;
}

const FitResult& of_a_rough_ball() {
  static const FitResult result = fit_all(drops(true), with_memory());
  return result;
}

TEST(MemoryOfFitAll, IsFittedBesideTheMainLawWhichItLeavesAlone) {
  FitConfig without = with_memory();
  without.memory = UseMemory::never;
  const FitResult alone = fit_all(drops(true), without);
  const FitResult& both = of_a_rough_ball();
  ASSERT_TRUE(both.memory);
  ASSERT_TRUE(both.memory->holds);
  ASSERT_EQ(both.memory->nodes.size(), both.law.nodes.size());
  for (std::size_t k = 0; k < both.law.nodes.size(); ++k) {
    const NodeEstimate& node = both.memory->nodes[k];
    EXPECT_EQ(node.v_mps, both.law.nodes[k].v_mps);
    EXPECT_EQ(both.law.nodes[k].eps.value, alone.law.nodes[k].eps.value);
    // a normal exceeds 4 standard errors once in 16,000
    EXPECT_LT(std::abs(node.eps.value - restitution(SeriesLaw{}, node.v_mps)), 4.0 * *node.eps.se);
    // what drops know of themselves is worth much, if little at the end of drops as short as these, of which the
    // release is not known
    EXPECT_LT(*node.eps.se, 0.85 * *both.law.nodes[k].eps.se);
  }
  // nothing of what is written without memory changes with it, but for the constants, which are then of the fit with it
  auto j = nlohmann::ordered_json::parse(json_text(value_of(both)));
  const auto j_alone = nlohmann::ordered_json::parse(json_text(value_of(alone)));
  EXPECT_FALSE(alone.memory);
  EXPECT_FALSE(j_alone.contains("memory"));
  EXPECT_FALSE(j_alone.contains("roughness"));
  for (const char* key : {"memory", "roughness", "answer", "answers", "hand_off", "constants", "status"}) j.erase(key);
  for (const auto& [key, value] : j.items()) EXPECT_EQ(value, j_alone.at(key)) << key;
}

TEST(MemoryOfFitAll, IsInFitJsonWithItsLeakAndItsTests) {
  const MemoryFit& memory = *of_a_rough_ball().memory;
  const auto j = nlohmann::json::parse(json_text(value_of(of_a_rough_ball())));
  const auto& m = j.at("memory");
  EXPECT_EQ(m.at("n"), 500);
  EXPECT_EQ(m.at("n_drops"), 10);
  EXPECT_EQ(j.at("constants").at("A4").at("value"), memory.parameters[1].estimate.value);
  EXPECT_EQ(m.at("leak").at("value"), 1.0 - memory.keep.value);
  EXPECT_EQ(m.at("leak").at("ci95").at(0), 1.0 - memory.keep.ci95->hi);
  EXPECT_EQ(m.at("leak").at("ci95").at(1), 1.0 - memory.keep.ci95->lo);
  EXPECT_GT(m.at("loglik").get<double>(), m.at("loglik_independent").get<double>());
  double n = 0.0;
  for (const double count : m.at("transform_counts")) n += count;
  EXPECT_EQ(n, 500.0);
  // two-sided; the last by how 10 drops differ
  const auto& tests = m.at("tests");
  for (const std::string test : {"leak", "release"})
    EXPECT_NEAR(tests.at(test + "_p").get<double>(),
                std::erfc(std::abs(tests.at(test + "_z").get<double>()) / std::sqrt(2.0)), 1e-9);
  EXPECT_NEAR(tests.at("mechanism_p").get<double>(),
              2.0 * student_t_below(-std::abs(tests.at("mechanism_z").get<double>()), 9.0), 1e-9);
  EXPECT_EQ(j.at("roughness").at("q"), memory.roughness.q.value);
  EXPECT_EQ(j.at("roughness").at("mechanism_p"), tests.at("mechanism_p"));
}

TEST(MemoryOfFitAll, IsAnsweredInATextAndHandedOnToDemCodes) {
  const FitResult& result = of_a_rough_ball();
  const FitInWords words = in_words(result, drops(true));
  const auto answer = std::find_if(words.findings.begin(), words.findings.end(),
                                   [](const Finding& f) { return f.question == "Do the fluctuations remember?"; });
  ASSERT_NE(answer, words.findings.end());
  EXPECT_THAT(answer->answer, ::testing::StartsWith("Yes: "));
  EXPECT_THAT(answer->answer, ::testing::HasSubstr("rms tilt of the contact's normal"));
  ASSERT_TRUE(result.dem_export);
  EXPECT_THAT(result.dem_export->snippets.back().text, ::testing::HasSubstr("restitution_with_memory"));
}

TEST(MemoryOfFitAll, GivesAnswerQuestionsAndDemCodesOneSetOfNumbers) {
  const FitResult& result = of_a_rough_ball();
  const MemoryFit& memory = *result.memory;
  ASSERT_TRUE(memory.holds && result.curve);
  const Constants& constants = result.constants;
  EXPECT_TRUE(constants.with_memory);
  ASSERT_EQ(constants.parameters.size(), memory.parameters.size());
  for (std::size_t k = 0; k < memory.parameters.size(); ++k)
    EXPECT_EQ(constants.parameters[k].estimate.value, memory.parameters[k].estimate.value);
  EXPECT_EQ(constants.covariance, memory.covariance);
  const CurveNode& middle = result.curve->nodes[result.curve->nodes.size() / 2];
  EXPECT_EQ(result.dem_export->v_mps, middle.v_mps);
  EXPECT_NEAR(result.dem_export->eps, middle.eps.value, 1e-6);  // straight between the points
  const FitInWords words = in_words(result, drops(true));
  ASSERT_TRUE(words.answer.at);
  EXPECT_EQ(words.answer.at->eps.value, middle.eps.value);
  const auto in_words_of = [](const std::vector<NamedEstimate>& parameters) {
    std::vector<std::string> texts;
    for (const NamedEstimate& p : parameters)
      if (p.estimate.identified) texts.push_back(p.name + " = " + fit::in_words(p.estimate.value, p.estimate.se));
    return texts;
  };
  for (const Finding& f : words.findings) {
    const bool is_dependence = f.question == "How does ε depend on speed?";
    const bool is_comparison = f.question == "Do the fluctuations remember?";
    if (is_dependence) {
      for (const CurveNode& node : result.curve->nodes)
        EXPECT_THAT(f.answer, ::testing::HasSubstr(fit::in_words(node.eps.value, node.eps.se)));
      for (const std::string& text : in_words_of(constants.parameters))
        EXPECT_THAT(f.answer, ::testing::ContainsRegex(text + ".*by the fit with memory"));
    }
    for (const std::string& independent : in_words_of(result.law.parameters))
      if (is_comparison)
        EXPECT_THAT(f.answer, ::testing::ContainsRegex("impacts taken as independent give.*" + independent));
      else
        EXPECT_THAT(f.answer, ::testing::Not(::testing::HasSubstr(independent))) << f.question;
  }
}

TEST(MemoryOfFitAll, LeavesOutTheWarningsOfImpactsTakenAsIndependent) {
  FitResult result = of_a_rough_ball();
  result.law.pearson = {100.0, 10.0, 1e-9};
  const auto warns = [&] {
    const FitInWords words = in_words(result, drops(true));
    return std::any_of(words.notes.begin(), words.notes.end(),
                       [](const Note& note) { return note.kind == NoteKind::scatter_not_as_fitted; });
  };
  EXPECT_FALSE(warns());
  result.memory->holds = false;
  EXPECT_TRUE(warns());
}

TEST(MemoryOfFitAll, OfIndependentImpactsIsWarnedOfAndNotHandedOn) {
  const FitResult result = fit_all(drops(false), with_memory());
  const FitInWords words = in_words(result, drops(false), UseMemory::always);
  ASSERT_TRUE(result.memory);
  EXPECT_FALSE(result.memory->holds);
  EXPECT_TRUE(result.curve && result.law.law);
  EXPECT_FALSE(result.constants.with_memory);
  ASSERT_FALSE(words.notes.empty());
  EXPECT_EQ(words.notes.front().kind, NoteKind::memory_fails);
  for (const Finding& f : words.findings)
    if (f.question == "Do the fluctuations remember?") {
      EXPECT_THAT(f.answer, ::testing::StartsWith("No"));
    }
  for (const Snippet& snippet : result.dem_export->snippets)
    EXPECT_THAT(snippet.text, ::testing::Not(::testing::HasSubstr("restitution_with_memory")));
  EXPECT_EQ(nlohmann::json::parse(json_text(value_of(result))).at("memory").at("holds"), false);
}

TEST(MemoryOfFitAll, WhereLongIsMadeOfFiveDropsOfThirtyImpactsAndNotOfLess) {
  FitConfig config = with_memory();
  config.memory = UseMemory::where_long;
  config.compare_recordings = false;
  const RestitutionSamples all = drops(true);
  const auto part = [&](std::int64_t n_drops, std::int64_t n_impacts) {
    RestitutionSamples samples;
    for (const RestitutionSample& s : all)
      if (s.drop < n_drops && s.impact <= n_impacts) samples.push_back(s);
    EXPECT_EQ(samples.size(), static_cast<std::size_t>(n_drops * n_impacts));
    return samples;
  };
  EXPECT_TRUE(fit_all(part(5, 30), config).memory);
  EXPECT_FALSE(fit_all(part(4, 30), config).memory);
  EXPECT_FALSE(fit_all(part(5, 29), config).memory);
  // of a failure that nobody asked about nothing is said
  RestitutionSamples independent = drops(false);
  std::erase_if(independent, [](const RestitutionSample& s) { return s.drop > 4; });
  const FitResult result = fit_all(independent, config);
  ASSERT_TRUE(result.memory);
  EXPECT_FALSE(result.memory->holds);
  for (const Note& note : in_words(result, independent).notes)
    EXPECT_TRUE(severity_of(note.kind) == Severity::detail || note.kind != NoteKind::memory_fails);
}

TEST(MemoryOfFitAll, IsAStepOfTheProgress) {
  RestitutionSamples few = drops(true);
  few.resize(40);
  std::vector<double> done;
  const FitResult result = fit_all(few, with_memory(), [&](double n, double of) {
    EXPECT_EQ(of, 6.0);
    done.push_back(n);
  });
  EXPECT_THAT(done, ::testing::ElementsAre(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0));
  ASSERT_TRUE(result.memory);
  EXPECT_EQ(result.memory->status, FitStatus::too_few_samples);
  const auto j = nlohmann::json::parse(json_text(value_of(result)));
  EXPECT_TRUE(j.at("roughness").is_null());
  EXPECT_TRUE(j.at("memory").at("leak").is_null());
  EXPECT_TRUE(j.at("memory").at("tests").is_null());
  EXPECT_THAT(texts_of(in_words(result, few, UseMemory::always).notes, Severity::warning),
              ::testing::Contains(::testing::StartsWith("memory could not be fitted: ")));
}

TEST(RoughnessOfABall, IsFoundWithinItsErrorWhateverItsInertia) {
  RoughnessConfig config;
  config.n_goodness = 0;
  RestitutionSamples samples = drops(true);
  Ball thin_shell = *samples.front().conditions.ball;
  thin_shell.inertia_factor = 2.0 / 3.0;
  name_ball(samples, thin_shell, {});
  samples[7].flags = {Flag::missing_impact};
  const RoughnessResult shell = measure_roughness(samples, config);
  ASSERT_TRUE(shell.memory.holds);
  EXPECT_LT(std::abs(shell.memory.roughness.q.value - kQ), 4.0 * *shell.memory.roughness.q.se);
  // 500 widths know q to a tenth or so; were it the start value there would be no such error
  EXPECT_LT(*shell.memory.roughness.q.se, 0.2 * kQ);
  EXPECT_DOUBLE_EQ(shell.memory.roughness.s2_no_slip, shell.memory.roughness.q.value * (5.0 / 3.0));
  EXPECT_EQ(shell.n_left_out.at("missing_impact"), 1u);
  EXPECT_EQ(shell.memory.n_chains, 11u);  // the flagged impact parts its drop
  const auto j = nlohmann::json::parse(json_text(value_of(shell)));
  EXPECT_EQ(j.at("roughness").at("s2_no_slip"), shell.memory.roughness.s2_no_slip);
  EXPECT_EQ(j.at("roughness").at("inertia_factor"), 2.0 / 3.0);
}

TEST(RoughnessOfABall, NamesSurfacesWhoseOffsetsHaveThatVariance) {
  // 1e5 asperities of one radius, solid ball: s2 = 2/N, c = 5/7 without slip and 5/2 without friction
  const double s2 = 2e-5;
  Estimate q;
  q.value = 5.0 / 7.0 * s2;
  const Roughness solid = equivalent_surfaces(q, kSolidBallInertia);
  EXPECT_NEAR(solid.s2_no_slip, s2, 1e-15 * s2 * 4);
  EXPECT_NEAR(solid.s2_frictionless, q.value / 2.5, 1e-20);
  EXPECT_NEAR(solid.n_constant_radii, 1e5, 1e-8);
  EXPECT_NEAR(solid.lambda_exponential, s2, 1e-19);
  // s2 = (1/2) sqrt(pi w/N) of uniform radii
  EXPECT_NEAR(0.5 * std::sqrt(std::numbers::pi * solid.width_uniform_1e6 / 1e6), s2, 1e-17);
  // two components
  EXPECT_NEAR(std::pow(solid.rms_tilt_no_slip_deg * std::numbers::pi / 180.0, 2), 2.0 * s2, 1e-17);
  // as fit_memory has it
  const Roughness& of_fit = of_a_rough_ball().memory->roughness;
  const Roughness again = equivalent_surfaces(of_fit.q, kSolidBallInertia);
  EXPECT_DOUBLE_EQ(again.s2_frictionless, of_fit.s2_frictionless);
  EXPECT_DOUBLE_EQ(again.n_constant_radii, of_fit.n_constant_radii);
  EXPECT_DOUBLE_EQ(again.width_uniform_1e6, of_fit.width_uniform_1e6);
}

TEST(RoughnessOfABall, RefusesInertiaThatNoBallHas) {
  for (const double factor : {0.0, -0.4, 1.1, std::nan("")})
    EXPECT_THROW(equivalent_surfaces({}, factor), InvalidArgument) << factor;
}

}  // namespace
}  // namespace bouncelab::report
