// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/subband_errors.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "bouncelab/core/random.hpp"

namespace bouncelab::detection {
namespace {

/// Residuals of n impacts of 64 samples: random in the first n_directions, 0 in the others.
std::vector<std::vector<float>> residuals_in(std::size_t n_directions, std::size_t n, double gain = 1.0) {
  Random random(1, RandomStream::test, 0);
  std::vector<std::vector<float>> residuals(n, std::vector<float>(64, 0.0F));
  for (std::vector<float>& r : residuals)
    for (std::size_t k = 0; k < n_directions; ++k) r[k] = static_cast<float>(gain * random.normal());
  return residuals;
}

TEST(UnexplainedJitter, DegreesOfFreedomAreTheDirectionsThatResidualsAreSpreadOver) {
  for (const std::size_t n_directions : {4U, 12U, 40U})
    EXPECT_NEAR(degrees_of_freedom(residuals_in(n_directions, 32)) / static_cast<double>(n_directions), 1.0, 0.25)
        << n_directions;
}

TEST(UnexplainedJitter, DegreesOfFreedomDoNotDependOnTheGain) {
  EXPECT_NEAR(degrees_of_freedom(residuals_in(12, 32, 1e-3)), degrees_of_freedom(residuals_in(12, 32)), 1e-3);
}

TEST(UnexplainedJitter, DegreesOfFreedomAreAtLeastInPhaseAndInQuadrature) {
  EXPECT_EQ(degrees_of_freedom(residuals_in(1, 32)), 2.0);
  EXPECT_EQ(degrees_of_freedom(residuals_in(12, 1)), 2.0);
  EXPECT_EQ(degrees_of_freedom({}), 2.0);
}

}  // namespace
}  // namespace bouncelab::detection
