// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_data.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace bouncelab::fit {
namespace {

const std::vector<double> kSpeeds{0.01, 0.25, 0.6, 1.0, 1.2, 3.7, 20.0};

TEST(Columns, AreWhatOneSampleAfterTheOtherGives) {
  // exponentials of logarithms below 10: some ten units in the last place
  constexpr double kRounding = 3e-15;
  const std::vector<double> powers = powers_of(kSpeeds, 0.4);
  ScatterModel scatter;
  scatter.v_ref_mps = 0.5;
  scatter.log_below = {-7.0, -1.2, 0.1};
  scatter.log_above = {-7.1, -1.0};
  const ScaleColumns b = scales_at(scatter, kSpeeds);
  for (std::size_t k = 0; k < kSpeeds.size(); ++k) {
    EXPECT_NEAR(powers[k] / std::pow(kSpeeds[k], 0.4), 1.0, kRounding);
    EXPECT_NEAR(b.below[k] / scatter.below(kSpeeds[k]), 1.0, kRounding);
    EXPECT_NEAR(b.above[k] / scatter.above(kSpeeds[k]), 1.0, kRounding);
  }
  for (const RestitutionLaw& law :
       {RestitutionLaw(SeriesLaw{}), RestitutionLaw(ViscoelasticLaw{0.02}), RestitutionLaw(ConstantLaw{0.9}),
        RestitutionLaw(TableLaw{{0.1, 1.0}, {0.99, 0.9}})}) {
    const std::vector<double> eps = restitutions(law, kSpeeds);
    for (std::size_t k = 0; k < kSpeeds.size(); ++k) EXPECT_NEAR(eps[k], restitution(law, kSpeeds[k]), kRounding);
  }
}

TEST(Columns, DropsAreNumberedAsTheyAreMet) {
  DropNumbers numbers;
  const auto number_of = [&](const RestitutionSample& sample) { return numbers.of(sample); };
  RestitutionSample a, b, c;
  a.drop = 7;
  b.drop = 3;
  c.drop = 7;
  c.recording = "other";
  EXPECT_EQ(number_of(a), 0u);
  EXPECT_EQ(number_of(a), 0u);
  EXPECT_EQ(number_of(b), 1u);
  EXPECT_EQ(number_of(c), 2u);
  EXPECT_EQ(number_of(a), 0u);
}

}  // namespace
}  // namespace bouncelab::fit
