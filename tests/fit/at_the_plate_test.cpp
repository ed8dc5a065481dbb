// SPDX-License-Identifier: GPL-3.0-or-later
// What an interval holds (docs/physics.md, 9): drag and contact, taken out where they are known.
#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "curve/plate_samples.hpp"
#include "integrated_flight.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {
namespace {

using Bounce = testing::IntegratedFlight;

template <class Deceleration>
Bounce integrated(double launch_mps, Deceleration deceleration) {
  return testing::integrated_flight(launch_mps, kDefaultGravity_mps2, 2000, deceleration);
}
Bounce in_air(const Ball& ball, double launch_mps) {
  return integrated(launch_mps, [&](double v) { return drag_rate_per_s(ball, {}, v) * v; });
}

TEST(Flight, WithDragIsThatOfTheIntegratedMotion) {
  for (const double kappa_per_m : {0.009, 0.13, 1.0})
    for (const double u : {0.1, 0.5, 3.0}) {
      const Bounce truth = integrated(u, [&](double v) { return kappa_per_m * v * v; });
      const Flight flight = flight_with_drag(truth.duration_s, kDefaultGravity_mps2, kappa_per_m);
      EXPECT_NEAR(flight.launch_mps / u, 1.0, 3e-7) << u;  // the last step's parabola: (1/2000)^2 of the drag's change
      EXPECT_NEAR(flight.landing_mps / truth.landing_mps, 1.0, 3e-7) << u;
      // down from the summit: the height goes as the square of the landing speed without drag
      const double summit_m = std::log1p(kappa_per_m * u * u / kDefaultGravity_mps2) / (2.0 * kappa_per_m);
      EXPECT_NEAR(fall_with_drag_mps(summit_m, kDefaultGravity_mps2, kappa_per_m) / truth.landing_mps, 1.0, 3e-7) << u;
    }
}

TEST(Flight, FromAHeightHasASpeedThatGivesTheHeightBack) {
  for (const double kappa_per_m : {0.009, 0.13, 1.0})
    for (const double height_m : {0.05, 2.0})
      EXPECT_NEAR(fall_height_m(fall_with_drag_mps(height_m, kDefaultGravity_mps2, kappa_per_m), kDefaultGravity_mps2,
                                kappa_per_m) /
                      height_m,
                  1.0,
                  1e-13);  // rounding, of 1 - (v/v_t)^2 = .02 at least
  EXPECT_EQ(fall_height_m(1.01 * std::sqrt(kDefaultGravity_mps2 / 0.13), kDefaultGravity_mps2, 0.13),
            HUGE_VAL);  // beyond the limit speed
}

TEST(Flight, WithoutAirIsTheParabola) {
  EXPECT_EQ(flight_with_drag(0.2, kDefaultGravity_mps2, 0.0).launch_mps, 0.1 * kDefaultGravity_mps2);
  EXPECT_NEAR(flight_with_drag(0.2, kDefaultGravity_mps2, 1e-9).landing_mps, 0.1 * kDefaultGravity_mps2, 1e-9);
  EXPECT_EQ(fall_with_drag_mps(0.1, kDefaultGravity_mps2, 0.0), std::sqrt(0.2 * kDefaultGravity_mps2));
  EXPECT_EQ(fall_height_m(2.0, kDefaultGravity_mps2, 0.0), 4.0 / (2.0 * kDefaultGravity_mps2));
}

TEST(Drag, IsThatOfTheStandardCurve) {
  // kappa of the balls of docs/physics.md, 9, at about 1 m/s, two digits
  const auto kappa = [](const char* ball, double v) { return drag_per_m(ball_from_text(ball), {}, v); };
  EXPECT_NEAR(kappa("steel:6mm", 1.0), 0.0115, 0.0005);
  EXPECT_NEAR(kappa("table-tennis", 3.0), 0.11, 0.01);
  EXPECT_NEAR(kappa("golf", 1.0), 0.0073, 0.0005);
  EXPECT_NEAR(kappa("basketball", 1.0), 0.0195, 0.001);
  // C_d = .4 +- .03 where it hardly depends on speed (Re 2e3 to 2e4)
  for (const double v : {1.0, 3.0, 6.0})
    EXPECT_NEAR(kappa("table-tennis", v) * 2.0 * 2.7e-3 / (1.2 * 3.14159 * 0.02 * 0.02), 0.41, 0.04) << v;
  // Stokes' where it creeps
  EXPECT_NEAR(drag_rate_per_s(Ball{}, {}, 1e-5) * mass_kg(Ball{}) / (6.0 * 3.14159265 * 1.813e-5 * 3e-3), 1.0, 0.01);
}

/// Impact times of a ball that bounces by the law in air, with contacts of Hertz' duration.
Onsets times_of(const Ball& ball, const RestitutionLaw& law, bool drag, bool contact) {
  Onsets onsets;
  double v = std::sqrt(2.0 * kDefaultGravity_mps2 * 0.1), t = 0.1;
  if (drag) v = fall_with_drag_mps(0.1, kDefaultGravity_mps2, drag_per_m(ball, {}, 0.85 * v));
  for (int k = 0; k < 90 && v > 0.2; ++k) {
    Onset o;
    o.impact = k;
    o.t_s = t;
    onsets.push_back(o);
    const double u = v * restitution(law, v);
    const Bounce flight = drag ? in_air(ball, u) : Bounce{2.0 * u / kDefaultGravity_mps2, u};
    t += flight.duration_s + (contact ? contact_duration(ball, kGlass)->at(v) : 0.0);
    v = flight.landing_mps;
  }
  return onsets;
}

double worst_error(const RestitutionSamples& samples, const RestitutionLaw& law) {
  double worst = 0.0;
  for (const auto& s : samples) worst = std::max(worst, std::abs(s.eps - restitution(law, s.v_mps)));
  return worst;
}

TEST(AtThePlate, DragAndContactOfANamedBallAreTakenOut) {
  const RestitutionLaw law = SeriesLaw{}, soft = ConstantLaw{0.9};
  for (const auto& [name, ball_law, raw_error, error] :
       {std::tuple{"steel:6mm", law, 5e-4, 5e-5}, std::tuple{"table-tennis", soft, 4e-3, 1.5e-4}}) {
    RestitutionConfig config;
    config.ball = ball_from_text(name);
    config.plate = kGlass;
    config.drop_height_m = 0.1;
    const Onsets onsets = times_of(*config.ball, ball_law, true, true);
    RestitutionSamples raw = restitution_samples(onsets, config).samples, more = raw;
    for (std::size_t k = 0; k < raw.size(); ++k) raw[k].sigma_eps = 1e-5, more[k].eps += 1e-5;
    const RestitutionSamples at = at_the_plate(raw), at_more = at_the_plate(more);
    for (std::size_t k = 0; k < raw.size(); ++k)  // to 1e-3: of drag, 1e-2, the next power
      EXPECT_NEAR(*at[k].sigma_eps, at_more[k].eps - at[k].eps, 1e-8) << name << " " << raw[k].v_mps;
    ASSERT_EQ(at.size(), onsets.size() - 1);  // the first impact counts
    EXPECT_GT(worst_error(raw, ball_law), raw_error) << name;
    // kappa is that of one speed in each flight: a twentieth of what drag does, as C_d changes along it
    EXPECT_LT(worst_error(at, ball_law), error) << name;
    EXPECT_TRUE(at[0].conditions.drag_corrected && at[0].conditions.contact_time_corrected);
  }
}

/// Where a ball thrown up comes to rest, by steps of Euler and Heun.
double integrated_rise_m(double launch_mps, double kappa_per_m) {
  constexpr double kStep_s = 1e-5;
  const auto a = [&](double v) { return -kDefaultGravity_mps2 - kappa_per_m * v * std::abs(v); };
  double z = 0.0, v = launch_mps;
  for (;;) {
    const double next = v + 0.5 * kStep_s * (a(v) + a(v + kStep_s * a(v)));
    if (next < 0.0) return z + 0.5 * v * v / kDefaultGravity_mps2;
    z += 0.5 * kStep_s * (v + next), v = next;
  }
}
/// How fast one that was let go is below.
double integrated_fall_mps(double height_m, double kappa_per_m) {
  constexpr double kStep_s = 1e-5;
  const auto a = [&](double v) { return kDefaultGravity_mps2 - kappa_per_m * v * v; };
  double z = 0.0, v = 0.0;
  for (;;) {
    const double next = v + 0.5 * kStep_s * (a(v) + a(v + kStep_s * a(v)));
    if (z + 0.5 * kStep_s * (v + next) > height_m)
      return v + (next - v) * (height_m - z) / (0.5 * kStep_s * (v + next));
    z += 0.5 * kStep_s * (v + next), v = next;
  }
}

TEST(AtThePlate, HeightsGiveTheCoefficientBackInAirAndInVacuum) {
  const auto eps_at = [](double v) { return 0.9 - 0.02 * v; };
  for (const double kappa_per_m : {0.0, 0.013, 0.13}) {
    Onsets onsets;
    double h_m = 1.5;
    for (int k = 0; k < 6; ++k) {
      Onset o;
      o.impact = k, o.t_s = k, o.fall_m = h_m, o.sigma_fall_m = 1e-3;
      onsets.push_back(o);
      const double v =
          kappa_per_m > 0.0 ? integrated_fall_mps(h_m, kappa_per_m) : std::sqrt(2.0 * kDefaultGravity_mps2 * h_m);
      const double u = v * eps_at(v);
      h_m = kappa_per_m > 0.0 ? integrated_rise_m(u, kappa_per_m) : 0.5 * u * u / kDefaultGravity_mps2;
    }
    const RestitutionSamples raw = restitution_samples(onsets, {}).samples;
    ASSERT_EQ(raw.size(), 5U);  // the first impact counts
    AirAndContact known;
    known.gravity_mps2 = kDefaultGravity_mps2, known.kappa_per_m = kappa_per_m;
    known.has_drag = kappa_per_m > 0.0, known.has_contact = false, known.of_heights = true;
    const RestitutionSamples at = at_the_plate(raw, known, {});
    for (std::size_t k = 0; k < at.size(); ++k) {
      const double truth = eps_at(at[k].v_mps);
      EXPECT_NEAR(at[k].eps, truth, kappa_per_m > 0.0 ? 1e-6 : 1e-14) << kappa_per_m;  // steps of 1e-5 s
      if (kappa_per_m > 0.1) EXPECT_GT(truth - raw[k].eps, 5e-3);
    }
    // errors of the root of a ratio
    EXPECT_NEAR(*raw[0].sigma_eps, 0.5 * raw[0].eps * std::hypot(1e-3 / *onsets[0].fall_m, 1e-3 / *onsets[1].fall_m),
                1e-12);
  }
}

TEST(AtThePlate, ALaunchRisesAsIntegrated) {
  EXPECT_NEAR(rise_height_m(4.0, kDefaultGravity_mps2, 0.013), integrated_rise_m(4.0, 0.013), 1e-6);  // steps of 1e-5 s
  EXPECT_EQ(rise_height_m(4.0, kDefaultGravity_mps2, 0.0), 8.0 / kDefaultGravity_mps2);
}

TEST(AtThePlate, TheErrorOfADropsHeightIsOfItsFirstCoefficientAlone) {
  RestitutionConfig config;
  config.drop_height_m = 0.1;
  Onsets onsets = times_of({}, ConstantLaw{0.8}, false, false);
  for (Onset& onset : onsets) onset.sigma_t_s = 1e-6;
  AirAndContact known;
  known.has_drag = known.has_contact = false;
  const PlateSamples exact = plate_samples(restitution_samples(onsets, config).samples, known, {});
  config.sigma_height_m = 1e-3;
  const RestitutionSamples samples = restitution_samples(onsets, config).samples;
  EXPECT_NEAR(*samples[0].sigma_v_mps / samples[0].v_mps, 0.005, 1e-15);  // half of a hundredth
  const PlateSamples of = plate_samples(samples, known, {});
  EXPECT_NEAR(of.timing(0, 0) - exact.timing(0, 0), std::pow(0.005 * samples[0].eps, 2), 1e-12);
  for (Eigen::Index k = 1; k < of.size(); ++k)
    EXPECT_NEAR(of.timing(k, 0), exact.timing(k, 0), 1e-9 * exact.timing(k, 0)) << k;
  EXPECT_NEAR(of.timing(0, 1), exact.timing(0, 1), 1e-9 * std::abs(exact.timing(0, 1)));
}

TEST(AtThePlate, WhatHoldsNeitherStaysAsItIs) {
  const RestitutionLaw law = SeriesLaw{};
  RestitutionConfig config;
  config.air_kgpm3 = 0.0;
  config.instant_contacts = true;
  const RestitutionSamples raw = restitution_samples(times_of({}, law, false, false), config).samples;
  const RestitutionSamples at = at_the_plate(raw);
  for (std::size_t k = 0; k < raw.size(); ++k) EXPECT_EQ(raw[k].eps, at[k].eps);
  // speeds that somebody measured: of no gravity, and so of no intervals
  RestitutionSamples measured(3);
  for (RestitutionSample& s : measured) s.v_mps = 1.0, s.eps = 0.8;
  for (const RestitutionSample& s : at_the_plate(measured)) EXPECT_EQ(s.eps, 0.8);
}

TEST(AtThePlate, DragBiasIsThatOfTheTable) {
  // docs/physics.md, 9: 1.6e-4 and 6e-4 at .6 and 1.2 m/s of the steel ball, two digits of a shift that grows by a
  // tenth between samples
  const RestitutionLaw law = SeriesLaw{};
  const auto raw = restitution_samples(times_of({}, law, true, false), {}).samples;
  for (const auto& [v, bias] : {std::pair{0.6, -2.6e-4}, std::pair{1.2, -8.3e-4}}) {
    const auto nearest = std::min_element(raw.begin(), raw.end(), [v = v](const auto& a, const auto& b) {
      return std::abs(a.v_mps - v) < std::abs(b.v_mps - v);
    });
    EXPECT_NEAR(nearest->eps - restitution(law, nearest->v_mps), bias, 0.1 * std::abs(bias)) << v;
  }
}

TEST(Restitution, RejectsANegativeHeightDensityOrAir) {
  RestitutionConfig config;
  config.drop_height_m = -0.1;
  EXPECT_THROW(restitution_samples({}, config), InvalidArgument);
  config = {};
  config.ball = Ball{};
  config.ball->material.density_kgpm3 = 0.0;
  EXPECT_THROW(restitution_samples({}, config), InvalidArgument);
  config = {};
  config.air_kgpm3 = -1.0;
  EXPECT_THROW(restitution_samples({}, config), InvalidArgument);
}

}  // namespace
}  // namespace bouncelab::fit
