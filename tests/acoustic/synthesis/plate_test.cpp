// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/plate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::synthesis {
namespace {

/// So thin that Mindlin's correction is below 1e-6: the frequencies are those of Kirchhoff's theory.
constexpr double kThin_m = 1e-4;
const Material kSteelLike{200e9, 0.30, 7800.0};

double thin_plate_constant(double thickness_m, const Material& m) {
  return std::sqrt(m.youngs_modulus_pa * thickness_m * thickness_m /
                   (12.0 * m.density_kgpm3 * (1.0 - m.poisson_ratio * m.poisson_ratio)));
}

/// omega a^2 sqrt(rho h / D) of the first modes.
std::vector<double> frequency_factors(double a_m, double b_m, std::size_t n) {
  Ground ground;
  ground.carrier = {a_m, b_m, kThin_m, kSteelLike};
  ground.carrier_damping = {0.0, 1e-9};
  const double unit_radps = thin_plate_constant(kThin_m, kSteelLike) / (a_m * a_m);
  const PlateModes plate(ground, 80.0 * unit_radps / (2.0 * kPi));
  std::vector<double> factors;
  for (std::size_t k = 0; k < n; ++k) factors.push_back(2.0 * kPi * plate.modes()[k].frequency_hz / unit_radps);
  return factors;
}

TEST(PlateModes, AFreeSquarePlateHasTheFrequenciesOfTheLiterature) {
  // converged values, nu = 0.3, e.g. Narita, J. Sound Vib. (2000), doi:10.1006/jsvi.2000.3019; given to four digits
  const std::vector<double> expected{13.47, 19.60, 24.27, 34.80, 34.80, 61.09};
  const std::vector<double> found = frequency_factors(1.0, 1.0, expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR(found[k], expected[k], 0.006) << "mode " << k;
}

TEST(PlateModes, AFreePlateOfThreeToTwoLiesJustBelowLeissasUpperBounds) {
  // Leissa (1973), Table C21, a/b = 1.5, nu = 0.3: 36 beam functions, upper bounds; those of his square plate are
  // up to 1.0% above the converged values
  const std::vector<double> leissa{20.128, 21.603, 46.654, 50.293, 58.201, 67.494};
  const std::vector<double> found = frequency_factors(1.5, 1.0, leissa.size());
  for (std::size_t k = 0; k < leissa.size(); ++k) {
    EXPECT_LT(found[k], leissa[k]) << "mode " << k;
    EXPECT_GT(found[k], 0.989 * leissa[k]) << "mode " << k;
  }
}

TEST(PlateModes, AFreeDiskHasTheFrequenciesOfItaoAndCrandall) {
  Ground ground;
  const Material material{200e9, 0.33, 7800.0};
  ground.carrier = {1.0, 1.0, 10.0, material};  // so thick that it has no mode of its own down here
  ground.disk = CircularDisk{0.5, kThin_m, material};
  ground.disk_damping = {0.0, 1e-9};
  const double unit_radps = thin_plate_constant(kThin_m, material) / 0.25;
  const PlateModes plate(ground, 22.0 * unit_radps / (2.0 * kPi));
  // lambda^2 for (nodal diameters, circles) = (2,0) twice, (0,1), (3,0) twice, (1,1) twice, (4,0) twice; nu = 0.33
  const std::vector<double> expected{5.2620, 5.2620, 9.0689, 12.2439, 12.2439, 20.5129, 20.5129, 21.5272, 21.5272};
  ASSERT_EQ(plate.modes().size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)  // published to 1e-4
    EXPECT_NEAR(2.0 * kPi * plate.modes()[k].frequency_hz / unit_radps, expected[k], 2e-4) << "mode " << k;
}

TEST(PlateModes, ShapesAreOrthogonalWithMeanSquareOne) {
  const PlateModes plate(ground_of(kGlass), 20e3);
  const std::size_t n = plate.modes().size();
  constexpr int kGrid = 300;  // midpoint rule: error of order (wavenumber x spacing)^2 / 24 = 4e-4 at 20 kHz
  std::vector<double> gram(n * n, 0.0), shapes(n);
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      plate.shapes_under_ball(0.30 * ((i + 0.5) / kGrid - 0.5), 0.20 * ((j + 0.5) / kGrid - 0.5), shapes);
      for (std::size_t p = 0; p < n; ++p)
        for (std::size_t q = 0; q <= p; ++q) gram[p * n + q] += shapes[p] * shapes[q] / (kGrid * kGrid);
    }
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t q = 0; q <= p; ++q) EXPECT_NEAR(gram[p * n + q], p == q ? 1.0 : 0.0, 2e-3) << p << ' ' << q;
}

TEST(PlateModes, MindlinGoesFromBendingToShearWaves) {
  const double nu = kGlass.poisson_ratio;
  const double h = 0.019;
  // long waves: Kirchhoff's omega = k^2 sqrt(D / rho h), short by (k h)^2 (1/(1-nu) 12/pi^2 + 1/...)/12 = 1e-6 here
  const double k_long = 0.05;
  const double kirchhoff_hz = k_long * k_long * thin_plate_constant(h, kGlass) / (2.0 * kPi);
  EXPECT_NEAR(mindlin_frequency_hz(k_long, h, kGlass) / kirchhoff_hz, 1.0, 1e-6);
  // short waves: speed sqrt(pi^2/12) of the shear wave's, reached like 1/(k h)^2
  const double shear_mps = std::sqrt(kGlass.youngs_modulus_pa / (2.0 * (1.0 + nu)) / kGlass.density_kgpm3);
  const double k_short = 1e5;
  EXPECT_NEAR(2.0 * kPi * mindlin_frequency_hz(k_short, h, kGlass) / k_short, kPi / std::sqrt(12.0) * shear_mps, 1.0);
}

TEST(Ground, OnlyWhatLiesOnTheSurfaceIsOnIt) {
  EXPECT_TRUE(contains(ground_of(kGlass), 0.149, -0.099));
  EXPECT_FALSE(contains(ground_of(kGlass), 0.151, 0.0));
  EXPECT_TRUE(contains(ground_of(kSiliconCarbide), 0.03, 0.03));
  EXPECT_FALSE(contains(ground_of(kSiliconCarbide), 0.04, 0.04));
}

}  // namespace
}  // namespace bouncelab::synthesis
