// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/normal_laplace.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "law/normal_laplace.hpp"

namespace bouncelab::fit {
namespace {

TEST(ModeOffset, IsWhereTheDensityIsHighest) {
  for (const double rho : {-5.0, -1.0, 0.0, 1.0, 4.0})
    for (const double asymmetry : {-3.0, -0.4, 0.0, 0.3, 2.0}) {
      const double at = mode_offset(asymmetry, rho).value, tau = std::exp(rho);
      const double below = std::exp(-0.5 * asymmetry), above = std::exp(0.5 * asymmetry);
      // d log f / dd is 0 there; rounding of two Mills ratios of 1/tau each
      EXPECT_NEAR(normal_laplace(at, below, above, tau).d_location * tau, 0.0, 1e-9) << rho << " " << asymmetry;
    }
}

TEST(ModeOffset, GoesFromTheJointOfTheExponentialsToTheirMean) {
  EXPECT_NEAR(mode_offset(0.5, -12.0).value, 0.0, 1e-4);  // of order tau
  // next order of the asymptotic series of Mills' ratio: 1/tau^2 of the offset
  EXPECT_NEAR(mode_offset(0.5, 6.0).value / (2.0 * std::sinh(0.25)), 1.0, 1e-4);
  EXPECT_NEAR(mode_offset(0.5, 20.0).value / (2.0 * std::sinh(0.25)), 1.0, 1e-6);
  EXPECT_EQ(mode_offset(0.0, 0.3).value, 0.0);
}

TEST(ModeOffset, DerivativesAreThoseOfItsValue) {
  constexpr double h = 1e-5;  // central differences: error h^2, rounding 1e-16 / h
  for (const double rho : {-4.0, -0.5, 0.0, 2.0})
    for (const double asymmetry : {-2.0, 0.0, 0.7}) {
      const ModeOffset offset = mode_offset(asymmetry, rho);
      EXPECT_NEAR(offset.d_asymmetry,
                  (mode_offset(asymmetry + h, rho).value - mode_offset(asymmetry - h, rho).value) / (2 * h), 1e-8);
      EXPECT_NEAR(offset.d_rho,
                  (mode_offset(asymmetry, rho + h).value - mode_offset(asymmetry, rho - h).value) / (2 * h), 1e-8);
    }
}

}  // namespace
}  // namespace bouncelab::fit
