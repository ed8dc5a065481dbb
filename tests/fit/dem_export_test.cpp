// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/dem_export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>

#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

TEST(DemExport, FillsTheParameterOfEveryCodeWithEpsAtTheSpeedStated) {
  const auto fit = fit_law(testing::independent_samples({}, 2000, 0.2, 1.4, 0.0), {});
  const auto handed = dem_export(fit, 0.6);
  ASSERT_TRUE(handed);
  EXPECT_NEAR(handed->eps, restitution(*fit.law, 0.6), 1e-15);
  ASSERT_EQ(handed->snippets.size(), 4u);
  char number[16];
  std::snprintf(number, sizeof number, "%.6f", handed->eps);
  for (const Snippet& s : handed->snippets) {
    EXPECT_THAT(s.text, ::testing::HasSubstr(number)) << s.program;
    EXPECT_THAT(s.text, ::testing::HasSubstr("0.6 m/s")) << s.program;
    EXPECT_THAT(s.text, ::testing::HasSubstr("constant")) << s.program;
  }
  EXPECT_THAT(handed->warning, ::testing::Not(::testing::HasSubstr("outside")));
  EXPECT_THAT(dem_export(fit, 5.0)->warning, ::testing::HasSubstr("outside the data"));
}

/// The value of "1 - 0.05 * std::pow(v, 0.2) + ..." and of a quotient of two such sums in brackets.
double value_of(const std::string& expression, double v) {
  if (const auto quotient = expression.find(") / ("); quotient != std::string::npos)
    return value_of(expression.substr(1, quotient - 1), v) / value_of(expression.substr(quotient + 5), v);
  std::istringstream in(expression);
  double sum = 0.0, exponent = 0.0;
  in >> sum;
  char sign = 0;
  for (double coefficient; in >> sign >> coefficient;) {
    std::string text;
    std::getline(in, text, ')');  // " * std::pow(v, 0.2"
    EXPECT_EQ(std::sscanf(text.c_str(), " * std::pow(v, %lf", &exponent), 1) << text;
    sum += (sign == '-' ? -1.0 : 1.0) * coefficient * std::pow(v, exponent);
  }
  return sum;
}

TEST(DemExport, WithRoughnessHasTheWholeLawAndTheSamplerWithMemory) {
  const auto samples = testing::independent_samples({}, 2000, 0.2, 1.4, 0.0);
  for (const LawKind kind : {LawKind::series, LawKind::viscoelastic}) {
    LawFitConfig config;
    config.kind = kind;
    const LawFit fit = fit_law(samples, config);
    const auto handed = dem_export(fit, 0.6, 2.5e-5);
    ASSERT_TRUE(handed);
    ASSERT_EQ(handed->snippets.size(), 5u);
    const Snippet& memory = handed->snippets.back();
    EXPECT_EQ(memory.program, "C++");
    EXPECT_THAT(memory.text, ::testing::HasSubstr("roughness_q = 2.5e-05;"));
    EXPECT_THAT(memory.text, ::testing::HasSubstr("double restitution_with_memory(double v_mps"));
    EXPECT_LT(memory.text.find("#include <cmath>"), memory.text.find("std::pow"));
    const auto begin = memory.text.find("{ return ") + 9, end = memory.text.find("; }", begin);
    ASSERT_LT(begin, end);
    for (const double v : {0.25, 0.6, 1.3})  // ten digits are printed
      EXPECT_NEAR(value_of(memory.text.substr(begin, end - begin), v), restitution(*fit.law, v), 1e-9) << v;
  }
}

TEST(DemExport, TableHasTheCurveAndItsBand) {
  const auto fit = fit_law(testing::independent_samples({}, 2000, 0.2, 1.4, 0.0), {});
  const Table table = law_table(fit);
  ASSERT_EQ(table.n_rows(), fit.curve.size());
  for (std::size_t k = 0; k < table.n_rows(); ++k) {
    EXPECT_LT((*table.reals("lo95"))[k], (*table.reals("eps"))[k]);
    EXPECT_GT((*table.reals("hi95"))[k], (*table.reals("eps"))[k]);
  }
}

TEST(DemExport, OfNoLawOrEpsAboveOneIsNothing) {
  EXPECT_FALSE(dem_export({}, 0.6));
  auto samples = testing::independent_samples({}, 200, 0.2, 1.4, 0.0);
  for (auto& s : samples) s.eps += 0.2;
  EXPECT_FALSE(dem_export(fit_law(samples, {}), 0.6));
}

}  // namespace
}  // namespace bouncelab::fit
