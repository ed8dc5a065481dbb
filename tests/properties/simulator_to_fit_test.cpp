// SPDX-License-Identifier: GPL-3.0-or-later
// The modules sim and fit against each other: the simulator's times, disturbed and not, give back the law that went in.
#include <gtest/gtest.h>

#include <cmath>

#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/sim/sim.hpp"

namespace bouncelab {
namespace {

struct Disturbed {
  bool drag = false, contact_time = false;
  double timing_sigma_s = 0.0;
};

/// 150 drops of 95 impacts on 100,000 asperities, as detected: later by all contacts before, and by the clock's noise.
Onsets detected(const Disturbed& by) {
  sim::SimulationConfig config;
  config.n_drops = 150;
  config.n_impacts_max = 96;
  if (by.drag) config.air = Air{};
  const sim::Surface surface =
      sim::make_surface(config.ball, 100000, sim::radius_law_from_text("uniform:0.5e-3,1.5e-3"), config.seed);
  const auto impacts = sim::simulate(config, surface).impacts;
  Onsets onsets;
  double contacts_s = 0.0;
  for (const Impact& impact : impacts.rows) {
    if (impact.impact == 0) contacts_s = 0.0;
    Onset onset;
    onset.drop = impact.drop;
    onset.impact = impact.impact;
    Random random(5, RandomStream::test, static_cast<std::uint64_t>(impact.drop * 1000 + impact.impact));
    onset.t_s = impact.t_s + contacts_s + by.timing_sigma_s * random.normal();
    onset.sigma_t_s = by.timing_sigma_s;
    onsets.push_back(onset);
    if (by.contact_time) contacts_s += hertz_contact_time_s(config.ball, kGlass, impact.v_mps);
  }
  return onsets;
}

fit::FitResult analysed(const Disturbed& by, bool corrected) {
  fit::RestitutionConfig config;
  config.ball = Ball{};
  config.plate = kGlass;
  if (!by.drag || !corrected) config.air_kgpm3 = 0.0;
  config.instant_contacts = !by.contact_time || !corrected;
  fit::FitConfig fit;
  fit.law.node_speeds_mps = {0.25, 0.6, 1.2};
  fit.n_goodness = 0;
  fit.budget.has_drag = by.drag;
  fit.budget.has_contact_time = by.contact_time;
  fit.budget.has_travel_time = false;
  return fit::fit_all(fit::restitution_samples(detected(by), config).samples, fit);
}

void expect_truth(const fit::FitResult& result) {
  ASSERT_EQ(result.law.nodes.size(), 3u);
  for (const fit::NodeEstimate& node : result.law.nodes) {
    const double error = node.eps.value - restitution(SeriesLaw{}, node.v_mps);
    EXPECT_LT(std::abs(error), 3.0 * *node.eps.se) << node.v_mps;
  }
}

TEST(SimulatorToFit, DragContactTimeAndTimingNoiseAreTakenOut) { expect_truth(analysed({true, true, 3e-6}, true)); }

TEST(SimulatorToFit, TrueTimesGiveBackTheLawAndCorrectionsLeaveABiasBelowOneStandardError) {
  // without drag the impacts are the same ones, disturbed or not
  const fit::FitResult clean = analysed({}, false), corrected = analysed({false, true, 3e-6}, true);
  expect_truth(clean);
  for (std::size_t j = 0; j < 3; ++j) {
    const fit::Estimate &a = clean.law.nodes.at(j).eps, &b = corrected.law.nodes.at(j).eps;
    EXPECT_LT(std::abs(b.value - a.value), *a.se) << clean.law.nodes[j].v_mps;
    EXPECT_LT(*b.se, 1.1 * *a.se);
  }
}

}  // namespace
}  // namespace bouncelab
