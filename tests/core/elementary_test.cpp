// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/elementary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <vector>

#include "bouncelab/core/random.hpp"

namespace bouncelab {
namespace {

constexpr int kArguments = 4000;

/// Error in units in the last place of the exact value; the reference has 11 more bits.
double largest_error_ulp(const std::function<double(double)>& f, const std::function<long double(long double)>& exact,
                         double lo, double hi) {
  Random random(1, RandomStream::test, 77);
  double largest = 0.0;
  for (int k = 0; k < kArguments; ++k) {
    const double x = random.uniform(lo, hi);
    const long double reference = exact(x);
    const double unit = std::ldexp(1.0, std::ilogb(static_cast<double>(reference)) - 52);
    largest = std::max(largest, static_cast<double>(std::abs((static_cast<long double>(f(x)) - reference) / unit)));
  }
  return largest;
}

TEST(Elementary, ErrorsAreAsStated) {
  const auto f = [](double (*g)(double)) { return g; };
  EXPECT_LT(largest_error_ulp(
                f(exp), [](long double x) { return std::exp(x); }, -40.0, 40.0),
            1.0);
  EXPECT_LT(largest_error_ulp(
                f(log), [](long double x) { return std::log(x); }, 1e-9, 20.0),
            1.0);
  EXPECT_LT(largest_error_ulp(
                f(sin), [](long double x) { return std::sin(x); }, -30.0, 30.0),
            1.0);
  EXPECT_LT(largest_error_ulp(
                f(cos), [](long double x) { return std::cos(x); }, -30.0, 30.0),
            1.0);
  EXPECT_LT(largest_error_ulp([](double x) { return pow(x, 0.1); },
                              [](long double x) { return std::pow(x, static_cast<long double>(0.1)); }, 1e-3, 9.0),
            2.0);
  EXPECT_LT(largest_error_ulp([](double x) { return pow(x, 0.687); },
                              [](long double x) { return std::pow(x, static_cast<long double>(0.687)); }, 1.0, 1e3),
            1.0 + 3.0 * 0.687 * 6.9);
}

TEST(Elementary, SineAndCosineTogetherAreThoseOfTheSingleFunctions) {
  Random random(1, RandomStream::test, 78);
  for (int k = 0; k < kArguments; ++k) {
    const double x = random.uniform(-20.0, 20.0);  // to a unit in the last place of 1
    EXPECT_NEAR(sin_cos(x).sin, sin(x), 2.3e-16);
    EXPECT_NEAR(sin_cos(x).cos, cos(x), 2.3e-16);
  }
}

TEST(Elementary, ManyAtOnceGiveTheBitsOfTheSingleFunctions) {
  Random random(1, RandomStream::test, 79);
  for (const std::size_t n : {0U, 1U, 2U, 3U, 7U, 8U, 13U, 64U, 1000U}) {
    std::vector<double> x(n), y(n);
    for (std::size_t k = 0; k < n; ++k) {
      x[k] = random.uniform(-1.0, 1.0) * (k % 3 == 0 ? 1.0 : 800.0);
      y[k] = exp(x[k]);
    }
    if (n > 10) x[3] = INFINITY, x[5] = -INFINITY, x[8] = 0.0;
    std::vector<double> exponentials = x, logarithms = y;
    exp_each(exponentials);
    log_each(logarithms);
    for (std::size_t k = 0; k < n; ++k) {
      EXPECT_EQ(exponentials[k], exp(x[k])) << x[k];
      EXPECT_EQ(logarithms[k], log(y[k])) << y[k];
    }
  }
}

TEST(Elementary, ComplexExponentialIsThatOfTheStandardLibrary) {
  const std::complex<double> z{-0.3, 2.1};
  EXPECT_NEAR(std::abs(exp(z) - std::exp(z)), 0.0, 1e-15);
  EXPECT_NEAR(std::abs(polar(1.7, -4.0) - std::polar(1.7, -4.0)), 0.0, 1e-15);
}

TEST(Elementary, EndsOfTheDomainsAreAsInTheStandardLibrary) {
  EXPECT_EQ(exp(-INFINITY), 0.0);
  EXPECT_EQ(exp(1000.0), INFINITY);
  EXPECT_EQ(log(0.0), -INFINITY);
  EXPECT_TRUE(std::isnan(log(-1.0)));
  EXPECT_TRUE(std::isnan(exp(NAN)));
  EXPECT_EQ(pow(0.0, 0.1), 0.0);
  EXPECT_EQ(pow(0.0, 0.0), 1.0);
  EXPECT_EQ(pow(7.0, 0.0), 1.0);
  EXPECT_EQ(power(-2.0, 3), -8.0);
  EXPECT_EQ(power(0.0, 0), 1.0);
  EXPECT_EQ(hypot(3.0, 4.0), 5.0);
  EXPECT_EQ(hypot(2.0, 3.0, 6.0), 7.0);
}

}  // namespace
}  // namespace bouncelab
