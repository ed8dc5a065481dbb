// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/dem_export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
