// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/distributions.hpp"

#include <gsl/gsl_cdf.h>
#include <gtest/gtest.h>

#include <cmath>

namespace bouncelab::fit {
namespace {

// GSL itself is good to 1e-12 here, less far out in the tails (1e-7 at t = -40, nu = 240)
constexpr double kTolerance = 1e-11;

TEST(Distributions, ChiSquareSurvivalIsThatOfGsl) {
  for (const double ndf : {1.0, 2.0, 3.5, 17.0, 120.0, 390.0})
    for (const double ratio : {1e-3, 0.2, 0.8, 1.0, 1.1, 2.0, 6.0}) {
      const double expected = gsl_cdf_chisq_Q(ratio * ndf, ndf);
      EXPECT_NEAR(chi2_survival(ratio * ndf, ndf), expected, kTolerance * expected) << ndf << " " << ratio;
    }
  EXPECT_EQ(chi2_survival(0.0, 3.0), 1.0);
  EXPECT_EQ(chi2_survival(1e9, 3.0), 0.0);
}

TEST(Distributions, StudentsTIsThatOfGsl) {
  for (const double nu : {0.5, 1.0, 2.7, 11.0, 240.0, 1100.0})
    for (const double t : {-9.0, -3.0, -0.4, -1e-6, 0.0, 1e-6, 0.7, 2.0, 15.0}) {
      const double expected = gsl_cdf_tdist_P(t, nu);
      EXPECT_NEAR(student_t_below(t, nu), expected, kTolerance * expected) << nu << " " << t;
    }
}

TEST(Distributions, FishersFIsThatOfGsl) {
  for (const double d1 : {1.0, 4.0, 19.0, 300.0})
    for (const double d2 : {1.0, 10.0, 75.0, 15000.0})
      for (const double f : {1e-3, 0.5, 1.0, 2.0, 12.0}) {
        const double expected = gsl_cdf_fdist_Q(f, d1, d2);
        EXPECT_NEAR(f_survival(f, d1, d2), expected, kTolerance * (1.0 + expected)) << d1 << " " << d2 << " " << f;
      }
  EXPECT_EQ(f_survival(0.0, 3.0, 5.0), 1.0);
  EXPECT_EQ(f_survival(HUGE_VAL, 3.0, 5.0), 0.0);
}

TEST(Distributions, QuantileOfStudentsTIsThatOfGsl) {
  for (const double nu : {1.0, 2.0, 5.0, 38.0})
    for (const double p : {0.5, 0.6, 0.84135, 0.975, 0.9995}) {
      const double expected = gsl_cdf_tdist_Pinv(p, nu);
      EXPECT_NEAR(student_t_quantile(p, nu), expected, kTolerance * (1.0 + expected)) << nu << " " << p;
    }
}

}  // namespace
}  // namespace bouncelab::fit
