// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/theory.hpp"

#include <cmath>
#include <span>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::sim {

double contact_factor(const Ball& ball, const ContactModel& model) {
  const double k = mass_kg(ball) * square(ball.radius_m) / moment_of_inertia_kgm2(ball);
  const auto* coulomb = std::get_if<CoulombContact>(&model);
  const auto* stronge = std::get_if<StrongeContact>(&model);
  const bool slips = std::holds_alternative<FrictionlessContact>(model) || (coulomb && coulomb->mu == 0.0) ||
                     (stronge && stronge->mu == 0.0);
  return slips ? k : k / (1.0 + k);
}

FluctuationSides expected_sides(const SimulationConfig& config, double q, double v_mps) {
  const auto refuse = [](const std::string& why) { throw InvalidArgument("expected scatter: " + why); };
  if (config.start_spin_radps != std::array<double, 3>{} || config.start_velocity_mps != std::array<double, 2>{})
    refuse("the ball is released with spin or sideways motion; release it at rest");
  if (config.tilt_rad > 0.0) refuse("the plate is tilted, which drives the ball sideways; set the tilt to 0");
  if (config.air) refuse("air drag is on; switch it off");
  const double g = config.gravity_mps2, slowest_release_mps = std::sqrt(2.0 * g * config.drop_height_min_m);
  if (!(v_mps > 0.0 && v_mps < slowest_release_mps))
    refuse("speed " + std::to_string(v_mps) + " m/s is not between 0 and the " + std::to_string(slowest_release_mps) +
           " m/s of the lowest release");
  constexpr int kHeights = 32, kBouncesMax = 1'000'000;
  const ImpactConditions at{v_mps, restitution(config.law, v_mps), restitution_slope(config.law, v_mps), 0.0};
  FluctuationSides mean;
  for (int i = 0; i < kHeights; ++i) {
    const double height_m =
        config.drop_height_min_m + (config.drop_height_max_m - config.drop_height_min_m) * (i + 0.5) / kHeights;
    double v = std::sqrt(2.0 * g * height_m), path = 0.0;
    for (int bounce = 0; bounce < kBouncesMax; ++bounce) {
      const double e = restitution(config.law, v), step = square((1.0 + e) * v);
      if (e * v < v_mps) {  // between this impact and the next: S is read off linearly in v
        path += step * (v - v_mps) / (v * (1.0 - e));
        break;
      }
      if (e >= 1.0) refuse("the law does not slow the ball down to " + std::to_string(v_mps) + " m/s");
      path += step;
      v *= e;
    }
    const FluctuationSides sides = fluctuation_sides(q, at, path);
    mean.below += sides.below / kHeights;
    mean.above += sides.above / kHeights;
  }
  return mean;
}

namespace {

/// Of the impacts of one drop.
void transform_drop(std::span<const Impact> impacts, const RestitutionLaw& law, double q, double reservoir_m2ps2,
                    std::span<double> transforms) {
  double w = reservoir_m2ps2;
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    const Impact& impact = impacts[k];
    if (!(impact.v_mps > 0.0))
      throw InvalidArgument("probability transforms: impact " + std::to_string(impact.impact) + " of drop " +
                            std::to_string(impact.drop) + " meets the ball on its way up, at " +
                            std::to_string(impact.v_mps) + " m/s; leave out what follows the impact before");
    const double eps = restitution(law, impact.v_mps);
    const Fluctuation fluctuation(q, {impact.v_mps, eps, restitution_slope(law, impact.v_mps), w});
    const double r = impact.eps_macro - eps;
    transforms[k] = fluctuation.cdf(r);
    w = fluctuation.reservoir_after(r);
  }
}

}  // namespace

std::vector<double> probability_transforms(const Impacts& impacts, const RestitutionLaw& law, double q,
                                           double reservoir_m2ps2, int n_threads) {
  const std::span<const Impact> all = impacts.rows;
  std::vector<std::size_t> begins;  // of the drops, and the end
  for (std::size_t k = 0; k < all.size(); ++k)
    if (k == 0 || all[k].impact == 0) begins.push_back(k);
  begins.push_back(all.size());
  std::vector<double> transforms(all.size());
  parallel_for(begins.size() - 1, n_threads, [&](std::size_t d) {
    const std::size_t n = begins[d + 1] - begins[d];
    transform_drop(all.subspan(begins[d], n), law, q, reservoir_m2ps2, std::span(transforms).subspan(begins[d], n));
  });
  return transforms;
}

}  // namespace bouncelab::sim
