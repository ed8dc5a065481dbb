// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/dem_export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/fit.hpp"
#include "dem/decks.hpp"
#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

RestitutionSamples viscoelastic_samples() {
  return testing::independent_samples({.law = ViscoelasticLaw{0.1}}, 2000, 0.2, 1.4, 0.0);
}

/// What dem_export is given of a fit.
struct Fitted {
  Curve curve;
  std::optional<ScatterModel> scatter;
};

Fitted fitted(const RestitutionSamples& samples, LawKind kind = LawKind::series) {
  FitConfig config;
  config.law.kind = kind;
  config.n_goodness = 0;
  config.compare_recordings = false;
  const FitResult result = fit_all(samples, config);
  return {result.curve.value(), result.law.scatter};
}

const Fitted& viscoelastic() {
  static const Fitted of = fitted(viscoelastic_samples());
  return of;
}

DemExport exported(const Fitted& fit, double v_mps = 0.6) {
  const auto result = dem_export(fit.curve, fit.scatter, v_mps, ball_from_text("steel:6mm"), kGlass);
  EXPECT_TRUE(result);
  return result.value_or(DemExport{});
}

const Snippet* find(const DemExport& all, const std::string& program, const std::string& model) {
  const auto found = std::find_if(all.snippets.begin(), all.snippets.end(),
                                  [&](const Snippet& s) { return s.program == program && s.model == model; });
  return found == all.snippets.end() ? nullptr : &*found;
}

TEST(DemExport, HandsOverTheRootMeanSquareOfTheSamplesNotTheirPeak) {
  // mean distances of 0.1 below and 0.01 above: the peak is far from the mean
  testing::SyntheticRun skew;
  skew.law = ConstantLaw{0.91};
  skew.below_at_1mps = 0.06;
  skew.above_at_1mps = 0.006;
  auto samples = testing::independent_samples(skew, 4000, 0.55, 0.65, 0.0);
  double squares = 0.0;
  for (const RestitutionSample& s : samples) squares += s.eps * s.eps / static_cast<double>(samples.size());
  const DemExport all = exported(fitted(samples, LawKind::constant));
  EXPECT_NEAR(all.eps * all.eps, squares, 5e-3);  // 0.1/sqrt(4000) twice over
  EXPECT_GT(all.peak, all.mean + 0.05);
  EXPECT_GT(all.eps, all.mean);
}

TEST(DemExport, HasInputsOfAllCodesAtTheSpeedStated) {
  const DemExport all = exported(viscoelastic());
  for (const char* program : {"LIGGGHTS", "LAMMPS", "Yade", "MercuryDPM"}) {
    const Snippet* s = find(all, program, "constant");
    ASSERT_TRUE(s) << program;
    EXPECT_THAT(s->text, ::testing::HasSubstr("at 0.6 m/s, root mean square")) << program;
    EXPECT_THAT(s->text, ::testing::HasSubstr("steel:6mm on glass")) << program;
  }
  for (const Snippet& s : all.snippets) EXPECT_EQ(s.text.find('@'), std::string::npos) << s.text;
}

TEST(DemExport, OfABallWhoseStiffnessIsNotKnownKeepsSizeAndMass) {
  const Fitted& fit = viscoelastic();
  const Ball rubber = ball_from_text("rubber:20mm");
  const auto of = [&](std::optional<double> youngs_modulus_pa) {
    return dem_export(fit.curve, fit.scatter, 0.6, rubber, kGlass, {}, youngs_modulus_pa);
  };
  EXPECT_THAT(of({})->ball, ::testing::StartsWith("rubber:20mm on glass; as stiff as steel, for it is not known how"));
  EXPECT_THAT(of(5e6)->ball, ::testing::Not(::testing::HasSubstr("steel, for")));
  // at 1e4 Pa the overlap is 1.4 times the radius
  EXPECT_THROW(of(1e4), InvalidArgument);
}

TEST(DemExport, KeepsThePlateAndSaysWhichOfTheTwoIsNotKnown) {
  using ::testing::HasSubstr;
  using ::testing::Not;
  const auto contact = [](const char* ball, const char* plate) {
    return dem_contact(ball_from_text(ball), plate_from_text(plate), 0.6);
  };
  const DemContact on_wood = contact("steel:6mm", "wood");
  EXPECT_THAT(on_wood.ball, HasSubstr("steel:6mm on wood; with E = 12.5 GPa of wood"));
  EXPECT_THAT(on_wood.ball, Not(HasSubstr("as stiff as steel")));
  const double e = 1.0 / ((1 - 0.09) / 200e9 + (1 - 0.35 * 0.35) / 12.5e9);
  EXPECT_NEAR(on_wood.k_n_pa / (4.0 / 3.0 * e), 1.0, 1e-3);  // 2.943 has four digits
  EXPECT_THAT(contact("rubber:20mm", "steel").ball, HasSubstr("rubber:20mm on steel; as stiff as steel, for it is"));
  EXPECT_EQ(contact("golf", "wood").ball, "golf on wood");  // measured
  EXPECT_EQ(dem_contact(ball_from_text("golf"), {}, 0.6).ball, "golf on glass, for the plate is not named");
  EXPECT_EQ(dem_contact({}, {}, 0.6).ball, "steel:6mm on glass, for ball and plate are not named");
  // a solid ball by its numbers is no table tennis ball, which touches the plate for 0.8 ms
  EXPECT_THAT(contact("radius=20mm,mass=2.7g", "steel").ball, HasSubstr("inertia=0.4 on steel; as stiff as steel"));
}

TEST(DemExport, EveryInputSaysHowSureEpsIsAndUpToWhichSpeedTheOverlapIsSmall) {
  const auto all = dem_export(viscoelastic().curve, viscoelastic().scatter, 0.6, {}, kGlass, {}, 1e7);
  ASSERT_TRUE(all && all->se);
  for (const Snippet& s : all->snippets) {
    if (s.model == "fluctuating") continue;
    EXPECT_THAT(s.text, ::testing::HasSubstr(formatted(" (standard error %.2g) at 0.6 m/s", *all->se))) << s.program;
    const auto number_before = [&](const char* words) {
      const auto at = s.text.find(words);
      return at == std::string::npos ? 0.0 : std::stod(s.text.substr(s.text.rfind(' ', at - 1)));
    };
    const double percent = number_before(" % of the radius");
    EXPECT_NEAR(number_before(" m/s it is below a quarter") / (0.6 * std::pow(25.0 / percent, 1.25)), 1.0, 0.01);
  }
}

TEST(DemExport, HasViscoelasticContactsWhereASphereExplainsTheCurveAndSaysSoWhereNot) {
  const DemExport all = exported(viscoelastic());
  ASSERT_TRUE(all.gamma);
  EXPECT_NEAR(*all.gamma, 0.1, 5e-4);  // scatter of 7e-4 over 2,000 samples, eps changes by 1 with gamma
  for (const char* program : {"LIGGGHTS", "LAMMPS", "Yade"}) EXPECT_TRUE(find(all, program, "viscoelastic")) << program;
  testing::SyntheticRun rises;
  rises.law = TableLaw{{0.2, 1.4}, {0.80, 0.85}};
  const DemExport none = exported(fitted(testing::independent_samples(rises, 2000, 0.2, 1.4, 0.0)));
  EXPECT_FALSE(none.gamma);
  EXPECT_FALSE(find(none, "LAMMPS", "viscoelastic"));
  EXPECT_EQ(
      std::count_if(none.missing.begin(), none.missing.end(),
                    [](const MissingModel& m) { return m.reason.starts_with("no viscoelastic model: a sphere"); }),
      3);  // LIGGGHTS, Yade, LAMMPS: MercuryDPM has no such contact
}

TEST(DemExport, SaysWhetherAConstantIsRightAtAllSpeedsOrAtOne) {
  EXPECT_THAT(exported(viscoelastic()).snippets.front().text,
              ::testing::HasSubstr("a constant eps is right at 0.6 m/s alone: eps goes from 0.9"));
  const DemExport same = exported(
      fitted(testing::independent_samples({.law = ConstantLaw{0.85}}, 2000, 0.2, 1.4, 0.0), LawKind::constant));
  EXPECT_THAT(same.warning, ::testing::HasSubstr("a constant ε is right, within"));
  EXPECT_THAT(same.warning, ::testing::Not(::testing::HasSubstr("alone")));
}

TEST(DemExport, HasDrawsOfAnyLawAndWithMemoryWhereThatFitIsGiven) {
  const DemExport all = exported(viscoelastic());
  for (const char* program : {"C++", "Python", "formulas"}) EXPECT_TRUE(find(all, program, "fluctuating")) << program;
  EXPECT_FALSE(find(all, "C++", "memory"));
  const DemMemory memory{ViscoelasticLaw{0.05}, 2.5e-5};
  const auto with = dem_export(viscoelastic().curve, viscoelastic().scatter, 0.6, {}, {}, memory);
  ASSERT_TRUE(with);
  const Snippet* sampler = find(*with, "C++", "memory");
  ASSERT_TRUE(sampler);
  EXPECT_THAT(sampler->text, ::testing::HasSubstr("roughness_q = 2.5e-05;"));
  EXPECT_THAT(sampler->text,
              ::testing::ContainsRegex("v < 0.2[0-9]* . 0.2[0-9]* : v > 1.[34][0-9]* . 1.[34][0-9]* : v"));
  EXPECT_THAT(sampler->text, ::testing::HasSubstr("double restitution_with_memory(double v_mps"));
  EXPECT_THAT(sampler->text, ::testing::HasSubstr("0.057672"));  // 1.15345 gamma: of its own law
}

TEST(DemExport, ContactIsHertzAndDampingEndsWhereTheCodesEndIt) {
  const DemContact contact = dem_contact(ball_from_text("steel:6mm"), kGlass, 0.6);
  const double e = 1.0 / ((1 - 0.09) / 200e9 + (1 - 0.22 * 0.22) / 70e9);
  EXPECT_NEAR(contact.k_n_pa / (4.0 / 3.0 * e), 1.0, 1e-3);  // 2.943 has four digits
  EXPECT_NEAR(contact.youngs_modulus_pa / (2 * 0.91 * e), 1.0, 1e-3);
  const std::string mercury = find(exported(viscoelastic()), "MercuryDPM", "constant")->text;
  const std::string shear = "setEffectiveShearModulus(";
  // 1/G* = 2 (2 - nu)/G of two alike, G = E/(2 (1 + nu)); eight digits are written
  EXPECT_NEAR(std::stod(mercury.substr(mercury.find(shear) + shear.size())) * 4 * 1.3 * 1.7 / contact.youngs_modulus_pa,
              1.0, 1e-7);
  EXPECT_NEAR(damping_to_parting(0.5), 0.481769, 1e-6);  // sqrt(5) ln 2/sqrt(ln^2 2 + pi^2)
  EXPECT_LT(damping_to_last_force(0.98), 1.005 * damping_to_parting(0.98));
  EXPECT_GT(damping_to_last_force(0.98), damping_to_parting(0.98));
  EXPECT_THAT(dem_contact(ball_from_text("radius=20mm,mass=20g"), {}, 0.6).ball,
              ::testing::HasSubstr("add E= and nu="));
  EXPECT_THAT(dem_contact(ball_from_text("radius=20mm,mass=20g,E=3GPa,nu=0.3"), {}, 0.6).ball,
              ::testing::HasSubstr("density=596.83,E=3GPa,nu=0.3"));
  // by the theory 1e-5; LAMMPS 29 Sep 2021 bounces 0.5692 at the second
  EXPECT_NEAR(viscoelastic_by_motion(0.1, 1.0, ContactEnd::force), 0.89286, 1e-5);
  EXPECT_NEAR(viscoelastic_by_motion(0.56213766, 0.6, ContactEnd::surfaces), 0.5692, 3e-4);
  EXPECT_THAT(dem_contact(ball_from_text("table-tennis"), {}, 0.6).ball, ::testing::HasSubstr("table-tennis on glass"));
}

TEST(DemExport, TableHasTheCurveAndItsBand) {
  const std::vector<CurvePoint>& points = viscoelastic().curve.points;
  const Table table = law_table(points);
  ASSERT_EQ(table.n_rows(), points.size());
  for (std::size_t k = 0; k < table.n_rows(); ++k) {
    EXPECT_LT((*table.reals("lo95"))[k], (*table.reals("eps"))[k]);
    EXPECT_GT((*table.reals("hi95"))[k], (*table.reals("eps"))[k]);
  }
}

TEST(DemExport, OfEpsAboveOneOrOfNoneIsNothing) {
  for (const double eps : {1.1, 0.0, -0.2}) {
    Curve curve;
    curve.nodes = {{0.6, normal_estimate(eps, 1e-3), {}, {}}};
    EXPECT_FALSE(dem_export(curve, {}, 0.6, {}, {})) << eps;
    curve.nodes[0].eps.value = 0.9;
    curve.points = {{0.2, eps, {}}, {1.4, eps, {}}};
    EXPECT_FALSE(dem_export(curve, {}, 0.2, {}, {})) << eps;
  }
}

}  // namespace
}  // namespace bouncelab::fit
