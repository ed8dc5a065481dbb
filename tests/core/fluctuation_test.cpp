// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/fluctuation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab {
namespace {

/// Gauss-Legendre with 12 points in each of n pieces.
double integral(const std::function<double(double)>& f, double lo, double hi, int n) {
  double sum = 0.0;
  for (int k = 0; k < n; ++k) {
    const QuadratureRule rule = gauss_legendre(12, lo + (hi - lo) * k / n, lo + (hi - lo) * (k + 1) / n);
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) sum += rule.weights[i] * f(rule.nodes[i]);
  }
  return sum;
}

struct Case {
  double q;
  ImpactConditions at;
};

/// From no reservoir to one that makes r nearly normal, speeds and surfaces of the paper and beyond.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const double q : {1e-8, 2e-5, 3e-3})
    for (const double lambda : {0.0, 1e-3, 0.5, 10.0, 2e3, 1e6})
      if (q * lambda < 0.025) all.push_back({q, {0.6, 0.979, -0.008, lambda * 4.0 * q * 0.36}});
  return all;
}

constexpr double kEnd = 9.0;  // standard deviations: 1e-19 of a normal is left

/// sqrt(q X) = sqrt((highest - r)/(1 + eps)) runs over [0, end]: the density is smooth in it even at highest().
double r_of(const Fluctuation& f, const Case& c, double root) { return f.highest() - (1.0 + c.at.eps) * root * root; }
double root_at_end(const Fluctuation& f, const Case& c) {
  return std::sqrt(f.highest() / (1.0 + c.at.eps)) + kEnd * std::sqrt(c.q);
}
double root_at_begin(const Fluctuation& f, const Case& c) {
  return std::max(0.0, root_at_end(f, c) - 2.0 * kEnd * std::sqrt(c.q));
}

TEST(Fluctuation, DensityIntegratesToOneAndToTheProbabilityTransform) {
  for (const Case& c : cases()) {
    const Fluctuation f(c.q, c.at);
    const auto density = [&](double root) {
      return std::exp(f.log_density(r_of(f, c, root))) * (1.0 + c.at.eps) * 2.0 * root;
    };
    const double end = root_at_end(f, c), begin = root_at_begin(f, c);
    // 40 pieces of at most half a standard deviation: the quadrature is exact to rounding, of exponents of size
    // (a - b)^2/2 whose a and b = 1e3 carry 1e-16 each
    EXPECT_NEAR(integral(density, begin, end, 40), 1.0, 1e-11) << c.q << " " << c.at.reservoir_m2ps2;
    for (const double share : {0.05, 0.3, 0.5, 0.7, 0.95}) {
      const double root = begin + share * (end - begin);
      const double below = integral(density, root, root + 2.0 * kEnd * std::sqrt(c.q), 40),
                   cdf = f.cdf(r_of(f, c, root));
      EXPECT_NEAR(cdf, below, 1e-11) << c.q << " " << c.at.reservoir_m2ps2 << " " << share;
      if (below < 0.1 && below > 1e-14) {  // the range of the relative error stated
        EXPECT_NEAR(cdf / below, 1.0, 1e-8) << c.q << " " << c.at.reservoir_m2ps2 << " " << share;
      }
    }
    EXPECT_EQ(f.cdf(f.highest()), 1.0);
    EXPECT_EQ(f.log_density(f.highest() + 1e-3), -INFINITY);
  }
}

TEST(Fluctuation, QuantileInvertsTheProbabilityTransform) {
  for (const Case& c : cases()) {
    const Fluctuation f(c.q, c.at);
    double before = -INFINITY;
    for (const double p : {1e-12, 1e-3, 0.1, 0.5, 0.9, 0.999, 1.0 - 1e-9}) {
      const double r = f.quantile(p);
      EXPECT_GT(r, before);
      before = r;
      // r is the difference of f^2 w/(4 v^2) and q X, each rounded: at the largest lambda they are 1e3 times the width
      EXPECT_NEAR(f.cdf(r), p, 1e-11 * std::min(1.0, 1e6 * p)) << c.q << " " << c.at.reservoir_m2ps2 << " " << p;
    }
  }
}

TEST(Fluctuation, DrawsAreUniformUnderTheProbabilityTransform) {
  for (std::size_t k = 0; k < cases().size(); ++k) {
    const Case c = cases()[k];
    const Fluctuation f(c.q, c.at);
    Random random(3, RandomStream::test, k);
    std::vector<double> u;
    for (int i = 0; i < 4000; ++i) u.push_back(f.cdf(f.draw(random)));
    std::sort(u.begin(), u.end());
    double distance = 0.0;
    const auto n = static_cast<double>(u.size());
    for (std::size_t i = 0; i < u.size(); ++i)
      distance = std::max({distance, static_cast<double>(i + 1) / n - u[i], u[i] - static_cast<double>(i) / n});
    EXPECT_LT(distance, 1.95 / std::sqrt(n)) << k;  // Kolmogorov: p = 0.001, of 16 cases
  }
}

TEST(Fluctuation, WithoutReservoirIsAnExponentialBelowTheLaw) {
  const double q = 2e-5, eps = 0.979;
  const Fluctuation f(q, {0.6, eps, -0.008, 0.0});
  EXPECT_EQ(f.highest(), 0.0);
  const double mean = 2.0 * q * (1.0 + eps);
  for (const double r : {-1e-7, -1e-5, -1e-4, -1e-3}) {
    EXPECT_NEAR(f.log_density(r), r / mean - std::log(mean), 1e-13 * std::abs(r / mean - std::log(mean)));  // roundings
    EXPECT_NEAR(f.cdf(r) / std::exp(r / mean), 1.0, 1e-9);  // as the header states
  }
  // all that r took from the vertical motion is in the reservoir, less 1 - eps^2 of the part beside the centre:
  // t^2 = -r/(1 + eps)/(1 + r/(1 + eps)) without reservoir, to the order r^2 that log_density has
  const double r = -1e-4, v = 0.6, t2 = -r / (1.0 + eps), p = (1.0 + eps + r) * v;
  EXPECT_NEAR(f.reservoir_after(r), p * p * t2, 1e-4 * p * p * t2);
}

TEST(Fluctuation, OfAHugeReservoirStaysFinite) {
  for (const double w : {1.0, 1e6, 1e12}) {
    const Fluctuation f(2e-5, {0.01, 0.98, 0.0, w});
    const double r = f.quantile(0.5);
    EXPECT_TRUE(std::isfinite(r) && std::isfinite(f.log_density(r)));
    EXPECT_NEAR(f.cdf(r), 0.5, 1e-6);  // lambda = 1e20: the offset's 1e10 standard deviations carry 1e-6 of one
    EXPECT_GE(f.reservoir_after(r), 0.0);
  }
}

TEST(Fluctuation, KeepsTheEnergyButForTheDissipatedPart) {
  // reservoir_after against the collision itself, averaged over the offsets that give nearly the same r
  const double v = 0.5, eps = 0.98, slope = -0.01, q = 2e-5, w = 6e-5;
  const Fluctuation f(q, {v, eps, slope, w});
  const double lo = f.quantile(0.30), hi = f.quantile(0.32);
  Random random(5, RandomStream::test, 0);
  double sum = 0.0, sum2 = 0.0, expected = 0.0, weights = 0.0;
  for (int k = 0; k < 400000; ++k) {
    const double x = std::sqrt(q) * random.normal(), y = std::sqrt(q) * random.normal();
    const double approach = v + std::sqrt(w) * x;
    const double p = (1.0 + eps + slope * (approach - v)) * approach / (1.0 + x * x + y * y);
    const double r = p / v - 1.0 - eps;
    if (r < lo || r > hi) continue;
    const double weight = approach / v;  // faster contacts are more frequent
    const double after = (std::sqrt(w) - p * x) * (std::sqrt(w) - p * x) + p * p * y * y;
    const double error = after - f.reservoir_after(r);
    sum += weight * error;
    sum2 += weight * weight * error * error;
    expected += weight * after;
    weights += weight;
  }
  ASSERT_GT(weights, 7000.0);
  // four standard errors of the mean; and these are small against the mean change of w
  const double se = std::sqrt(sum2) / weights;
  EXPECT_LT(std::abs(sum) / weights, 4.0 * se);
  EXPECT_LT(se, 1e-3 * expected / weights);
}

TEST(Fluctuation, AveragedOverAnExponentialReservoirIsExactlyTwoExponentials) {
  const double q = 3e-5, path = 40.0;
  ImpactConditions at{0.5, 0.98, -0.01, 0.0};
  const FluctuationSides sides = fluctuation_sides(q, at, path);
  EXPECT_GT(sides.below, sides.above);
  const double mean_w = 2.0 * q * path;
  for (const double x : {-6.0, -2.0, -0.5, 0.4, 1.5, 5.0}) {
    const double r = x * (x < 0.0 ? sides.below : sides.above);
    const auto integrand = [&](double root_w) {  // p(r|w) has a root at its lower end in w where r > 0
      at.reservoir_m2ps2 = root_w * root_w;
      const double w = root_w * root_w;
      return std::exp(Fluctuation(q, at).log_density(r)) * std::exp(-w / mean_w) / mean_w * 2.0 * root_w;
    };
    // from the least reservoir that reaches r, to exp(-45)
    const double f = 1.0 + at.v_mps * at.eps_slope_spm / (1.0 + at.eps);
    const double begin = r > 0.0 ? 2.0 * at.v_mps / f * std::sqrt(r / (1.0 + at.eps)) * (1.0 + 1e-15) : 0.0;
    const double end = std::sqrt(mean_w * 45.0) + begin;
    const double p = integral(integrand, begin, end, 400);
    // pieces much finer than the density's width; the begin is rounded
    EXPECT_NEAR(p / std::exp(sides.log_density(r)), 1.0, 1e-8) << x;
  }
  const double total = integral([&](double r) { return std::exp(sides.log_density(r)); }, -40 * sides.below, 0, 40) +
                       integral([&](double r) { return std::exp(sides.log_density(r)); }, 0, 40 * sides.above, 40);
  EXPECT_NEAR(total, 1.0, 1e-12);
}

TEST(Fluctuation, OfADropsFirstImpactHasNoUpperSide) {
  const FluctuationSides sides = fluctuation_sides(2e-5, {1.4, 0.974, -0.01, 0.0}, 0.0);
  EXPECT_NEAR(sides.below, 2.0 * 1.974 * 2e-5, 1e-18);  // rounding
  EXPECT_EQ(sides.above, 0.0);
  EXPECT_EQ(sides.log_density(1e-9), -INFINITY);
}

TEST(Fluctuation, RefusesWhatIsOutsideItsRanges) {
  const ImpactConditions good{0.6, 0.98, 0.0, 1e-5};
  EXPECT_THROW(Fluctuation(0.0, good), InvalidArgument);
  EXPECT_THROW(Fluctuation(0.2, good), InvalidArgument);
  EXPECT_THROW(Fluctuation(1e-5, {0.0, 0.98, 0.0, 0.0}), InvalidArgument);
  EXPECT_THROW(Fluctuation(1e-5, {0.6, NAN, 0.0, 0.0}), InvalidArgument);
  EXPECT_THROW(Fluctuation(1e-5, {0.6, 0.98, -1.0, 0.0}), InvalidArgument);
  EXPECT_THROW(Fluctuation(1e-5, {0.6, 0.98, 0.0, -1e-9}), InvalidArgument);
  EXPECT_THROW(Fluctuation(1e-5, good).quantile(1.0), InvalidArgument);
  EXPECT_THROW(fluctuation_sides(1e-5, good, -1.0), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab
