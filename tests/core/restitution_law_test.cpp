// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/restitution_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

TEST(RestitutionLaw, ClosedFormsOfTheCoefficientsHold) {
  const double c2 =
      -std::sqrt(std::numbers::pi) * std::tgamma(0.6) / (std::pow(2.0, 0.2) * std::pow(5.0, 0.4) * std::tgamma(2.1));
  EXPECT_NEAR(kViscoelasticC[2], c2, 1e-14);  // a few roundings of numbers near 1
  EXPECT_NEAR(kViscoelasticC[4], 0.6 * c2 * c2, 1e-14);
}

TEST(RestitutionLaw, PaperConstantsGiveThePublishedCurve) {
  // docs/physics.md, five printed digits: half a unit of the last
  const SeriesLaw paper;
  const double v[] = {0.15, 0.3, 0.5, 0.7, 1.0, 1.4};
  const double eps[] = {0.98348, 0.98169, 0.97988, 0.97835, 0.97633, 0.97393};
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(restitution(paper, v[k]), eps[k], 0.5e-5) << "v = " << v[k];
}

TEST(RestitutionLaw, SeriesAgreesWithTheSumTermByTerm) {
  const SeriesLaw law{{0, 0, 0.1, 0, -0.2, 0.3, 0.05, 0.01, -0.02, 0.03, 0.04}};
  double sum = 1.0;
  for (std::size_t i = 1; i < law.a.size(); ++i)
    sum += kViscoelasticC[i] * law.a[i] * std::pow(0.7, 0.1 * static_cast<double>(i));
  EXPECT_NEAR(restitution(law, 0.7), sum, 1e-14);
}

TEST(RestitutionLaw, SlopeIsTheDerivative) {
  const TableLaw table{{0.2, 0.5, 1.0}, {0.99, 0.98, 0.96}};
  for (const RestitutionLaw& law :
       {RestitutionLaw{SeriesLaw{}},
        RestitutionLaw{SeriesLaw{{0, 0, 0.1, 0, -0.2, 0.3, 0.05, 0.01, -0.02, 0.03, 0.04}}},
        RestitutionLaw{ViscoelasticLaw{}}, RestitutionLaw{ConstantLaw{0.9}}, RestitutionLaw{table}})
    for (const double v : {0.1, 0.3, 0.7, 1.3}) {
      // central difference: error h^2/6 times the third derivative, of order eps'/v^2, and roundings 1e-16/h
      const double h = 1e-4 * v;
      const double difference = (restitution(law, v + h) - restitution(law, v - h)) / (2.0 * h);
      EXPECT_NEAR(restitution_slope(law, v), difference, 1e-7 * std::abs(difference) + 1e-10) << describe(law) << v;
    }
}

TEST(RestitutionLaw, ViscoelasticTendsToOneAtRestAndFollowsTheSeriesForSmallGamma) {
  EXPECT_EQ(restitution(ViscoelasticLaw{0.02}, 0.0), 1.0);
  // x = sqrt(gamma) v^0.1 = 0.01: the series with A_i = gamma^(i/2) up to C_10 leaves a rest of order x^5, whose Pade
  // coefficient is a fit, not C_5: their difference is below 1
  const double x = 0.01;
  SeriesLaw series{std::vector<double>(11, 0.0)};
  for (int i = 2; i <= 10; ++i) series.a[i] = std::pow(x, i);
  EXPECT_NEAR(viscoelastic_restitution(x), restitution(series, 1.0), 2e-8);
}

TEST(RestitutionLaw, TableInterpolatesAndHoldsItsEnds) {
  const TableLaw table{{0.2, 0.4}, {0.98, 0.96}};
  EXPECT_DOUBLE_EQ(restitution(table, 0.1), 0.98);
  EXPECT_DOUBLE_EQ(restitution(table, 0.3), 0.97);
  EXPECT_DOUBLE_EQ(restitution(table, 2.0), 0.96);
}

TEST(RestitutionLaw, IsReadFromText) {
  const double v = 0.5;
  const auto eps = [v](const char* text) { return restitution(restitution_law_from_text(text), v); };
  EXPECT_EQ(eps("series:A2=0.0467,A4=0.1339,A5=-0.2876"), restitution(SeriesLaw{}, v));
  EXPECT_EQ(eps("series"), restitution(SeriesLaw{}, v));
  EXPECT_EQ(eps("series:A10=0.1"), restitution(SeriesLaw{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1}}, v));
  EXPECT_EQ(eps("viscoelastic:0.01"), restitution(ViscoelasticLaw{0.01}, v));
  EXPECT_EQ(eps("constant:0.9"), 0.9);
  for (const char* text :
       {"", "series:", "series:A2", "series:A3=1", "series:A11=1", "series:A2=1,", "series:A2=.1,A4=.1,A2=.2",
        "constant:x", "constant:0", "viscoelastic:-1", "table", "newton:0.9"})
    EXPECT_THROW(restitution_law_from_text(text), InvalidArgument) << text;
  EXPECT_THROW(restitution_law_from_text("table:no-such-file.csv"), FileError);
}

TEST(RestitutionLaw, OfAnEmptyTableIsRefused) {
  for (const TableLaw& law : {TableLaw{}, TableLaw{{}, {0.9}}, TableLaw{{0.1, 0.2}, {0.9}}}) {
    EXPECT_THROW(restitution(law, 1.0), InvalidArgument);
    EXPECT_THROW(restitution_slope(law, 1.0), InvalidArgument);
  }
}

TEST(RestitutionLaw, BadParametersAreRefused) {
  EXPECT_THROW(validate(ViscoelasticLaw{-1.0}), InvalidArgument);
  EXPECT_THROW(validate(ConstantLaw{0.0}), InvalidArgument);
  EXPECT_THROW(validate(TableLaw{{0.2, 0.2}, {1, 1}}), InvalidArgument);
  EXPECT_THROW(validate(SeriesLaw{{0, 0, NAN}}), InvalidArgument);
}

TEST(Ball, HertzContactOfThePapersBallOnGlassLastsTensOfMicroseconds) {
  // docs/physics.md: 26 to 44 us between 1.4 m/s and small speeds
  EXPECT_NEAR(hertz_contact_time_s(Ball{}, kGlass, 1.4) * 1e6, 26.0, 1.5);
  EXPECT_NEAR(hertz_contact_time_s(Ball{}, kGlass, 0.2) / hertz_contact_time_s(Ball{}, kGlass, 1.0),
              std::pow(0.2, -0.2), 1e-12);
}

}  // namespace
}  // namespace bouncelab
