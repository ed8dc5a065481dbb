// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/normal_laplace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

namespace bouncelab::fit {
namespace {

double laplace(double d, double below, double above) {
  return std::exp(d > 0.0 ? -d / above : d / below) / (below + above);
}

/// The convolution by brute force: Simpson's rule in the normal's argument, the kink on a panel's edge.
double convolved(double d, double below, double above, double tau) {
  const auto integrand = [&](double z) {
    return std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI) * laplace(d - tau * z, below, above);
  };
  const double kink = std::clamp(d / tau, -12.0, 12.0);
  double sum = 0.0;
  for (const auto& [lo, hi] : {std::pair{-12.0, kink}, std::pair{kink, 12.0}}) {
    constexpr int kPanels = 20000;
    const double h = (hi - lo) / (2 * kPanels);
    if (h == 0.0) continue;
    for (int i = 0; i < kPanels; ++i) {
      const double z = lo + 2 * i * h;
      sum += h / 3.0 * (integrand(z) + 4.0 * integrand(z + h) + integrand(z + 2.0 * h));
    }
  }
  return sum;
}

/// Of one sample, from a block that has others beside it.
struct Density {
  double log_density, d_location, d_log_below, d_log_above;
};
constexpr std::size_t kPlace = 5, kSome = 7;  // of so many, not a multiple of any register's width

Density density(double d, double below, double above, double tau, double background = 0.0) {
  SidesBlock sides;
  sides.fill(below, above);
  Block ds, taus, inverse_taus;
  for (std::size_t k = 0; k < kBlockSize; ++k) ds[k] = d + (static_cast<double>(k) - kPlace) * tau;
  ds[kPlace] = d;
  taus.fill(tau);
  inverse_taus.fill(1.0 / tau);
  DensityBlock f;
  normal_laplace(kSome, ds.data(), sides, taus.data(), inverse_taus.data(), background, f);
  return {f.exponent[kPlace] + std::log(f.factor[kPlace]), f.d_location[kPlace], f.d_log_below[kPlace],
          f.d_log_above[kPlace]};
}

double cdf(double d, double below, double above, double tau) {
  SidesBlock sides;
  sides.fill(below, above);
  const double inverse_tau = 1.0 / tau;
  double result = 0.0;
  normal_laplace_cdf(1, &d, sides, &tau, &inverse_tau, &result);
  return result;
}

const std::vector<std::tuple<double, double, double>> kShapes{{1.0, 1.0, 0.01}, {1.0, 1.0, 1.0}, {1.0, 0.3, 0.5},
                                                              {0.2, 2.0, 1.0},  {1.0, 1.5, 8.0}, {0.05, 0.08, 1.0}};

TEST(MillsRatio, AgreesWithTheStandardLibrary) {
  for (double u = 0.0; u < 35.0; u += 0.0173) {
    const double expected = std::sqrt(M_PI / 2) * std::exp(0.5 * u * u) * std::erfc(u * std::sqrt(0.5));
    // erfc itself is good to a few ulp, exp(u^2/2) loses u^2/2 ulp
    EXPECT_NEAR(mills_ratio(u) / expected, 1.0, 1e-15 * (4.0 + u * u)) << u;
  }
}

TEST(NormalLaplace, IsTheConvolutionByBruteForce) {
  for (const auto& [below, above, tau] : kShapes)
    for (const double d : {-6.0, -1.7, -0.2, 0.0, 0.03, 0.9, 5.0}) {
      const double expected = convolved(d, below, above, tau);
      if (expected < 1e-25) continue;  // Simpson's own range of +-12 sigma ends there
      EXPECT_NEAR(std::exp(density(d, below, above, tau).log_density) / expected, 1.0, 1e-9)
          << d << " " << below << " " << above << " " << tau;
    }
}

TEST(NormalLaplace, DerivativesAreThoseOfItsLogarithm) {
  for (const auto& [below, above, tau] : kShapes)
    for (const double d : {-30.0, -1.7, -0.2, 0.0, 0.03, 0.9, 40.0}) {
      const auto f = density(d, below, above, tau);
      const auto at = [tau = tau](double x, double b, double a) { return density(x, b, a, tau).log_density; };
      const double h = 1e-5 * std::min(tau, std::min(below, above));
      const double g = 1e-5;
      // central differences: error h^2 f''' / 6 plus rounding 1e-16 |log f| / h
      const double tolerance = 1e-5 * (1.0 + std::abs(f.log_density));
      EXPECT_NEAR(f.d_location, -(at(d + h, below, above) - at(d - h, below, above)) / (2 * h),
                  tolerance / std::min(below, above));
      EXPECT_NEAR(f.d_log_below, (at(d, below * (1 + g), above) - at(d, below * (1 - g), above)) / (2 * g), tolerance);
      EXPECT_NEAR(f.d_log_above, (at(d, below, above * (1 + g)) - at(d, below, above * (1 - g))) / (2 * g), tolerance);
    }
}

TEST(NormalLaplace, IsAPureLaplaceFarFromThePeakAndForSmallTau) {
  // a convolved exponential tail is the tail times exp(tau^2 / (2 b^2))
  EXPECT_NEAR(density(50.0, 1.0, 0.7, 0.2).log_density, std::log(laplace(50.0, 1.0, 0.7)) + 0.5 * 0.04 / 0.49, 1e-12);
  EXPECT_NEAR(density(-50.0, 1.0, 0.7, 0.2).log_density, std::log(laplace(-50.0, 1.0, 0.7)) + 0.5 * 0.04, 1e-12);
  for (const double d : {-2.0, -0.1, 0.1, 2.0})
    EXPECT_NEAR(density(d, 1.0, 0.7, 1e-9).log_density, std::log(laplace(d, 1.0, 0.7)), 1e-12);
}

TEST(NormalLaplace, NeverOverflows) {
  for (const double tau : {1e-12, 1e-6, 1.0, 1e6})
    for (const double d : {-1e6, -1.0, 0.0, 1e-12, 1.0, 1e6}) {
      const auto f = density(d, 1e-4, 1e-3, tau);
      EXPECT_TRUE(std::isfinite(f.log_density)) << tau << " " << d;
      EXPECT_TRUE(std::isfinite(f.d_location) && std::isfinite(f.d_log_below) && std::isfinite(f.d_log_above));
    }
}

TEST(NormalLaplaceCdf, DifferentiatesToTheDensity) {
  for (const auto& [below, above, tau] : kShapes)
    for (const double d : {-4.0, -0.5, 0.01, 0.7, 3.0}) {
      const double h = 1e-4 * std::min(tau, std::min(below, above));
      const double slope = (cdf(d + h, below, above, tau) - cdf(d - h, below, above, tau)) / (2 * h);
      // h^2 relative curvature 1e-8, rounding 1e-16/h = 1e-10
      EXPECT_NEAR(slope, std::exp(density(d, below, above, tau).log_density), 1e-7);
    }
  EXPECT_NEAR(cdf(100.0, 1.0, 2.0, 0.5), 1.0, 1e-15);
  EXPECT_NEAR(cdf(-100.0, 1.0, 2.0, 0.5), 0.0, 1e-15);
}

TEST(NormalLaplaceInformation, TendsToTheClosedFormOfTheKink) {
  // 1 / (b_below b_above): what a location is worth, though the log-density has no second derivative there.
  // The loss by a small tau is of first order in tau / b.
  const double b = 1.0, a = 0.6, p = a / (a + b), q = 1.0 - p;
  const auto nearly = normal_laplace_information(b, a, 1e-4);
  EXPECT_NEAR(nearly(0, 0) * b * a, 1.0, 5e-4);
  EXPECT_NEAR(nearly(0, 1), -1.0 / (a + b), 5e-4);
  EXPECT_NEAR(nearly(0, 2), 1.0 / (a + b), 5e-4);
  EXPECT_NEAR(nearly(1, 1), q * (2.0 - q), 1e-4);
  EXPECT_NEAR(nearly(1, 2), -p * q, 1e-4);
  EXPECT_NEAR(nearly(2, 2), p * (2.0 - p), 1e-4);
}

TEST(NormalLaplace, DistributionFunctionOfTheNormalIsThatOfTheStandardLibrary) {
  std::vector<double> z;
  for (int k = -200; k <= 200; ++k) z.push_back(0.05 * k);
  std::vector<double> cdf = z;
  normal_cdf_each(cdf);
  for (std::size_t k = 0; k < z.size(); ++k) {
    const double expected = 0.5 * std::erfc(-z[k] * std::sqrt(0.5));
    // erfc is good to a few units in its last place, exp(-z^2/2) loses z^2/2 of them
    EXPECT_NEAR(cdf[k] / expected, 1.0, 1e-15 * (4.0 + z[k] * z[k])) << z[k];
  }
}

TEST(NormalLaplace, ABackgroundIsAddedToTheDensity) {
  constexpr double kBackground = 0.005;
  for (const double d : {-60.0, -4.0, 0.1, 3.0, 900.0}) {
    const Density alone = density(d, 1.0, 0.7, 0.2), both = density(d, 1.0, 0.7, 0.2, kBackground);
    const double f = std::exp(alone.log_density), sum = f + kBackground;
    // rounding of an exponent of at most 700
    EXPECT_NEAR(std::exp(both.log_density) / sum, 1.0, 1e-13) << d;
    EXPECT_NEAR(both.d_location, alone.d_location * f / sum, 1e-13) << d;
    EXPECT_NEAR(both.d_log_above, alone.d_log_above * f / sum, 1e-12) << d;
  }
}

TEST(ModeOffset, IsWhereTheDensityIsHighest) {
  for (const double rho : {-5.0, -1.0, 0.0, 1.0, 4.0})
    for (const double asymmetry : {-3.0, -0.4, 0.0, 0.3, 2.0}) {
      const double at = mode_offset(asymmetry, rho).value, tau = std::exp(rho);
      const double below = std::exp(-0.5 * asymmetry), above = std::exp(0.5 * asymmetry);
      // d log f / dd is 0 there; rounding of two Mills ratios of 1/tau each
      EXPECT_NEAR(density(at, below, above, tau).d_location * tau, 0.0, 1e-9) << rho << " " << asymmetry;
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
