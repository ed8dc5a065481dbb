// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/histogram_fit.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "synthetic_samples.hpp"

namespace bouncelab::fit {
namespace {

TEST(DensityPicture, CountsEverySample) {
  const auto samples = testing::independent_samples({}, 5000, 0.2, 1.4, 0.0);
  const auto picture = density_picture(samples);
  ASSERT_EQ(picture.counts.size(), picture.eps_edges.size() - 1);
  std::size_t n = picture.n_outside;
  for (const auto& row : picture.counts) {
    ASSERT_EQ(row.size(), picture.v_edges_mps.size() - 1);
    n = std::accumulate(row.begin(), row.end(), n);
  }
  EXPECT_EQ(n, 5000u);
  EXPECT_LE(picture.n_outside, 10u);  // the outermost 0.2 %, less the margin
}

TEST(DensityPicture, OfOneSpeedOrOneEpsHasAnArea) {
  RestitutionSamples samples(10);
  for (auto& s : samples) s.v_mps = 0.5, s.eps = 0.9;
  const auto picture = density_picture(samples);
  EXPECT_GT(picture.v_edges_mps.back(), picture.v_edges_mps.front());
  EXPECT_GT(picture.eps_edges.back(), picture.eps_edges.front());
  EXPECT_EQ(picture.n_outside, 0u);
}

TEST(DensityPicture, OfNothingIsEmpty) { EXPECT_TRUE(density_picture({}).counts.empty()); }

}  // namespace
}  // namespace bouncelab::fit
