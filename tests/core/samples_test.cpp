// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/samples.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

RestitutionSample sample(double eps) {
  RestitutionSample s;
  s.v_mps = 1.0;
  s.eps = eps;
  return s;
}

TEST(Samples, RoundTripThroughTheTableKeepsWhatTheyWereComputedWith) {
  RestitutionSamples samples{sample(0.9), sample(0.8), sample(0.7)};
  samples[0].conditions = {true,         false, true, 1.62, ball_from_text("squash,contact-time=3ms"),
                           std::nullopt, 1.1,   343.0};
  samples[2].conditions.ball = ball_from_text("radius=2.1cm,mass=4g,E=3GPa,nu=0.3,inertia=0.6");
  samples[2].conditions.plate = plate_from_text("granite");
  samples[1].conditions.contact_time_corrected = true;
  const Table table = to_table(samples);
  EXPECT_EQ(*table.texts("corrected"), (std::vector<std::string>{"drag|travel_time", "contact_time", ""}));
  const RestitutionSamples back = samples_from_table(table, "s.csv");
  ASSERT_EQ(back.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(back[k].conditions, samples[k].conditions) << k;
}

TEST(Samples, AreNamedAsOfABallOnlyAsFarAsItIsGiven) {
  RestitutionSamples samples{sample(0.9)};
  name_ball(samples, Ball{}, {});
  name_ball(samples, {}, kGlass);
  EXPECT_EQ(samples[0].conditions.ball, Ball{});
  EXPECT_EQ(samples[0].conditions.plate, kGlass);
}

TEST(Samples, ATableOfSpeedsAndCoefficientsIsEnough) {
  const RestitutionSamples samples = samples_from_table(
      Table{{{"v_mps", std::vector<double>{1.0, 2.0}}, {"eps", std::vector<double>{0.9, 0.8}}}}, "s.csv");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].impact, 1);
  EXPECT_EQ(samples[1].conditions, SampleConditions{});
  EXPECT_TRUE(samples[1].flags.empty());
}

TEST(Samples, AStandardErrorOfZeroIsNotKnown) {
  std::istringstream in("v_mps,eps,sigma_v_mps,sigma_eps\n1.5,0.85,0,0\n1.5,0.85,,\n1.2,0.85,0.1,0.002\n");
  const RestitutionSamples samples = samples_from_table(read_csv(in, "x", sample_columns()), "x");
  EXPECT_FALSE(samples[0].sigma_v_mps);
  EXPECT_EQ(samples[0].sigma_eps, samples[1].sigma_eps);  // of the digits
  EXPECT_EQ(samples[2].sigma_v_mps, 0.1);
  EXPECT_EQ(samples[2].sigma_eps, 0.002);
}

TEST(Samples, CorrectionsAreWordsThatAreKnown) {
  const auto conditions_of = [](const std::string& corrected) {
    return samples_from_table(Table{{{"v_mps", std::vector<double>{1.0}},
                                     {"eps", std::vector<double>{0.9}},
                                     {"corrected", std::vector<std::string>{corrected}}}},
                              "s.csv")
        .front()
        .conditions;
  };
  EXPECT_TRUE(conditions_of("drag|contact_time").drag_corrected);
  EXPECT_TRUE(conditions_of("drag|contact_time").contact_time_corrected);
  EXPECT_FALSE(conditions_of("drag").contact_time_corrected);
  // what is taken out of intervals once more for a word that is not understood makes them wrong
  for (const char* text : {"no_drag", "drag contact_time", "drag,contact_time", "drag|x"})
    EXPECT_THROW(conditions_of(text), FileError) << text;
}

TEST(Samples, ThatAreNoNumbersAreFlagged) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const RestitutionSamples samples = samples_from_table(
      Table{{{"v_mps", std::vector<double>{1.0, nan}}, {"eps", std::vector<double>{nan, 0.8}}}}, "s.csv");
  for (const RestitutionSample& s : samples) EXPECT_EQ(s.flags, Flags{Flag::not_finite});
}

}  // namespace
}  // namespace bouncelab
