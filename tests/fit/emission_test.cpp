// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory/emission.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/fluctuation.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kSpeed = 0.7, kEps = 0.98, kQ = 2e-5;

EmissionInput<double> input(double y, double reservoir, double noise) {
  EmissionInput<double> in{};
  in.y = y;
  in.noise_variance = square(noise);
  in.reservoir = reservoir;
  in.a = kQ * square(1.0 + kEps);
  in.b = 2.0 * kQ * (1.0 + kEps) * kSpeed;
  return in;
}

double density(double y, double reservoir, double noise) {
  return std::exp(emission(input(y, reservoir, noise)).log_density());
}

/// The same by quadrature: the density of the fluctuation, smeared by a normal. eps does not depend on the speed, and
/// contacts are not weighted by their speed of approach.
double smeared(double y, double reservoir, double noise) {
  constexpr int kSteps = 1500;
  const Fluctuation fluctuation(kQ, {kSpeed, kEps, 0.0, reservoir});
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    const double z = -8.0 + 16.0 * (k + 0.5) / kSteps, r = (y - noise * z) / kSpeed;
    const double weight = 1.0 + r / (1.0 + kEps) + 2.0 * kQ;
    sum += std::exp(-0.5 * z * z + fluctuation.log_density(r)) / weight;
  }
  return sum * 16.0 / kSteps / std::sqrt(2.0 * M_PI) / kSpeed;
}

TEST(Emission, IsTheSmearedDensityOfTheFluctuation) {
  const double unit = 2.0 * kQ * (1.0 + kEps) * kSpeed;
  // reservoirs of a first, a few and many impacts; from almost exact to as wide as the narrowest exponential
  for (const double reservoir : {1e-9, 2e-5, 3e-4, 5e-3})
    for (const double noise : {0.1, 1.0}) {
      const double sd = std::sqrt(kQ * reservoir) * (1.0 + kEps) + unit;
      double worst = 0.0, mass = 0.0;
      const int n = 200;
      for (int k = 0; k < n; ++k) {
        const double y = -unit + sd * (-10.0 + 20.0 * (k + 0.5) / n);
        const double exact = smeared(y, reservoir, noise * unit);
        worst = std::max(worst, std::abs(density(y, reservoir, noise * unit) - exact));
        mass += exact * 20.0 * sd / n;
      }
      EXPECT_NEAR(mass, 1.0, 0.02);  // the quadrature's own check: exponential tails beyond ten widths
      // of the highest density; the saddlepoint is least good at the edge of an exponential
      EXPECT_LT(worst * unit, noise < 0.5 && reservoir < 1e-4 ? 0.2 : 0.03) << reservoir << " " << noise;
    }
}

TEST(Emission, DerivativesAreThoseOfTheDensity) {
  const double unit = 2.0 * kQ * (1.0 + kEps) * kSpeed;
  for (const double reservoir : {2e-5, 3e-4, 5e-3})
    for (const double y : {-4e-4, -5e-5, 1e-5}) {
      EmissionInput<Jet> in{};
      in.y = Jet(y, 0);
      in.reservoir = Jet(reservoir, 1);
      in.noise_variance = Jet(square(unit), 2);
      in.a = Jet(kQ * square(1.0 + kEps), 3);
      in.b = Jet(unit);
      const Emission<Jet> found = emission(in);
      const auto difference = [&](auto&& change, double step) {
        EmissionInput<double> up = input(y, reservoir, unit), down = up;
        change(up, step);
        change(down, -step);
        return (emission(up).log_density() - emission(down).log_density()) / (2.0 * step);
      };
      const auto expect = [](double value, double reference) {
        EXPECT_NEAR(value, reference, 1e-4 * std::abs(reference) + 1e-6);
      };
      expect(found.log_density().v[0], difference([](auto& x, double h) { x.y += h; }, 1e-4 * unit));
      expect(found.log_density().v[1], difference([](auto& x, double h) { x.reservoir += h; }, 1e-4 * reservoir));
      expect(found.log_density().v[2],
             difference([](auto& x, double h) { x.noise_variance += h; }, 1e-4 * square(unit)));
      expect(found.log_density().v[3], difference([](auto& x, double h) { x.a += h; }, 1e-12));
      // those the filter is updated by leave out how the second-order term changes
      const double by_noise = difference([](auto& x, double h) { x.noise_mean += h; }, 1e-4 * unit);
      EXPECT_NEAR(found.by_noise.a, by_noise, 0.05 * std::abs(by_noise) + 0.3 / unit);
    }
}

TEST(Emission, ExtremesAreFinite) {
  for (const double y : {-1.0, -1e-2, 1e-2, 1.0})
    for (const double reservoir : {1e-12, 1e-6, 1.0})
      EXPECT_TRUE(std::isfinite(emission(input(y, reservoir, 1e-9)).log_density())) << y << " " << reservoir;
}

}  // namespace
}  // namespace bouncelab::fit
