// SPDX-License-Identifier: GPL-3.0-or-later
#include "restitution/flight_correction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kG = kDefaultGravity_mps2;

struct Bounce {
  double duration_s, landing_mps;
};

/// The flight by brute force: Runge-Kutta of fourth order in time, 2000 steps, the landing by the last step's parabola.
Bounce integrated(const Ball& ball, const Air& air, double launch_mps) {
  double z = 0.0, v = launch_mps, t = 0.0;
  const double h = 2.0 * launch_mps / kG / 2000.0;
  const auto a = [&](double w) { return -kG - std::copysign(drag_deceleration_mps2(ball, air, std::abs(w)), w); };
  for (;;) {
    const double k1 = a(v), k2 = a(v + 0.5 * h * k1), k3 = a(v + 0.5 * h * k2), k4 = a(v + h * k3);
    const double dz = h * (v + h * (k1 + k2 + k3) / 6.0), dv = h * (k1 + 2 * k2 + 2 * k3 + k4) / 6.0;
    if (z + dz < 0.0) break;
    z += dz;
    v += dv;
    t += h;
  }
  const double acceleration = a(v);
  const double rest = (v + std::sqrt(v * v - 2.0 * acceleration * z)) / -acceleration;  // v < 0: time to z = 0
  return {t + rest, -(v + acceleration * rest)};
}

TEST(Flight, WithDragIsThatOfTheIntegratedMotion) {
  const Ball ping_pong = ball_from_text("table-tennis");
  for (const Ball& ball : {Ball{}, ping_pong})
    for (const double u : {0.1, 0.5, 1.4}) {
      const Bounce truth = integrated(ball, {}, u);
      const Flight flight = flight_with_drag(ball, {}, truth.duration_s, kG);
      EXPECT_NEAR(flight.launch_mps / u, 1.0, 1e-7) << u;  // the last step's parabola: (1/2000)^2 of the drag's change
      EXPECT_NEAR(flight.landing_mps / truth.landing_mps, 1.0, 1e-7) << u;
    }
}

TEST(Flight, WithoutAirIsTheParabola) {
  const Flight flight = flight_with_drag({}, {1e-12, 1e-12}, 0.2, kG);
  EXPECT_NEAR(flight.launch_mps, 0.1 * kG, 1e-9);
  EXPECT_NEAR(flight.landing_mps, 0.1 * kG, 1e-9);
  EXPECT_NEAR(fall_with_drag_mps({}, {1e-12, 1e-12}, 0.1, kG), std::sqrt(0.2 * kG), 1e-9);
}

TEST(Flight, DragOfASteelBallIsThatOfSchillerAndNaumann) {
  // Re = 2 R v / nu = 398.4 at 1 m/s, Cd = 24/Re (1 + .15 Re^.687) = 0.6125; d = 3/8 rho_a v^2 Cd/(rho R) by hand
  EXPECT_NEAR(drag_deceleration_mps2({}, {}, 1.0), 0.375 * 1.204 * 0.6125 / (7900.0 * 3e-3), 3e-5);
}

/// Impact times of a ball that bounces by the law in air, with contacts of Hertz duration.
Onsets times_of(const RestitutionLaw& law, bool drag, bool contact) {
  const Ball ball;
  const Air air = drag ? Air{} : Air{1e-12, 1e-12};
  Onsets onsets;
  double v = fall_with_drag_mps(ball, air, 0.1, kG), t = 0.1;
  for (int k = 0; k < 90; ++k) {
    Onset o;
    o.impact = k;
    o.t_s = t;
    onsets.push_back(o);
    const double u = v * restitution(law, v);
    const Bounce flight = integrated(ball, air, u);
    t += flight.duration_s + (contact ? hertz_contact_time_s(ball, kGlass, v) : 0.0);
    v = flight.landing_mps;
  }
  return onsets;
}

double worst_error(const Restitution& r, const RestitutionLaw& law) {
  double worst = 0.0;
  for (const auto& s : r.samples) worst = std::max(worst, std::abs(s.eps - restitution(law, s.v_mps)));
  return worst;
}

TEST(Restitution, CorrectionsRemoveWhatDragAndContactTimeDo) {
  const RestitutionLaw law = SeriesLaw{};
  const Onsets onsets = times_of(law, true, true);
  RestitutionConfig config;
  config.ball = Ball{};
  config.plate = kGlass;
  config.correct_drag = config.correct_contact_time = true;
  config.drop_height_m = 0.1;
  const auto corrected = restitution_samples(onsets, config);
  EXPECT_EQ(corrected.samples.size(), 89u);  // the first impact counts
  EXPECT_GT(worst_error(restitution_samples(onsets, {}), law), 5e-4);
  // the contact's speed is taken from the flight after it: tau off by (1 - eps)/5 of 40 us in the smallest interval
  EXPECT_LT(worst_error(corrected, law), 1e-5);
  EXPECT_GT(*corrected.counts.mean_shift_drag, 2e-4);
  EXPECT_NE(*corrected.counts.mean_shift_contact_time, 0.0);
}

TEST(Restitution, DragTakenOutLeavesLessThanAnyExperimentCanTell) {
  const RestitutionLaw law = SeriesLaw{};
  RestitutionConfig config;
  config.ball = Ball{};
  config.correct_drag = true;
  // 220,000 impacts know eps(1.2 m/s) to 1.4e-6; the integrated flights are good to 1e-7
  EXPECT_LT(worst_error(restitution_samples(times_of(law, true, false), config), law), 3e-7);
}

TEST(Restitution, DragBiasIsThatOfTheTable) {
  // docs/physics.md: -1e-4, -3.6e-4, -6.3e-4, -9.6e-4 at .3, .7, 1.0, 1.3 m/s
  const RestitutionLaw law = SeriesLaw{};
  const auto raw = restitution_samples(times_of(law, true, false), {});
  const double expected[4][2] = {{0.3, -1e-4}, {0.7, -3.6e-4}, {1.0, -6.3e-4}, {1.3, -9.6e-4}};
  for (const auto& [v, bias] : expected) {
    const auto nearest = std::min_element(
        raw.samples.begin(), raw.samples.end(),
        [v = v](const auto& a, const auto& b) { return std::abs(a.v_mps - v) < std::abs(b.v_mps - v); });
    // the table's two digits and the next sample's distance in speed, 2 %
    EXPECT_NEAR(nearest->eps - restitution(law, nearest->v_mps), bias, 0.08 * std::abs(bias)) << v;
  }
}

TEST(Restitution, DragOfATableTennisBallIsThatOfTheHandCalculation) {
  // 2.7 g of 40 mm at 1 m/s: Re = 1.204 * 0.04 / 1.813e-5 = 2656, factor 1 + 0.15 Re^0.687 = 34.78, force 3 pi mu d v
  // times that = 2.377e-4 N, deceleration 0.0880 m/s^2: 1 part in 111 of gravity; of
  // the steel ball Re = 398.5, factor 10.17, 0.01167 m/s^2
  const Ball ball = ball_from_text("table-tennis");
  EXPECT_NEAR(drag_deceleration_mps2(ball, {}, 1.0), 0.0880, 5e-5);  // the digits given
  EXPECT_NEAR(drag_deceleration_mps2({}, {}, 1.0), 0.01167, 5e-6);
}

std::string refusal_of(const RestitutionConfig& config) {
  try {
    restitution_samples({}, config);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

TEST(Restitution, WhatNeedsABallIsRefusedWithoutOne) {
  using ::testing::HasSubstr;
  RestitutionConfig config;
  config.correct_drag = true;
  EXPECT_THAT(refusal_of(config), HasSubstr("--ball"));
  config.correct_drag = false;
  config.correct_contact_time = true;
  EXPECT_THAT(refusal_of(config), HasSubstr("--ball"));
  config.ball = ball_from_text("table-tennis");
  EXPECT_THAT(refusal_of(config), HasSubstr("--plate"));
  config.plate = kGlass;
  EXPECT_THAT(refusal_of(config), HasSubstr("contact-time="));
  config.ball = Ball{};
  EXPECT_EQ(refusal_of(config), "");
  config.plate.reset();
  config.ball = ball_from_text("table-tennis,contact-time=0.8ms");
  EXPECT_EQ(refusal_of(config), "");
}

TEST(Restitution, RejectsANegativeHeightOrDensity) {
  RestitutionConfig config;
  config.drop_height_m = -0.1;
  EXPECT_THROW(restitution_samples({}, config), InvalidArgument);
  config = {};
  config.ball = Ball{};
  config.ball->material.density_kgpm3 = 0.0;
  EXPECT_THROW(restitution_samples({}, config), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::fit
