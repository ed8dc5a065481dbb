// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/theory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::sim {
namespace {

/// int_E^inf (r - E)^k p(r) dr for k = 1, 2.
struct Excess {
  double first = 0.0, second = 0.0;
};

double density_of_normal(double z) { return exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2; }
double normal_beyond(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

Excess excess(const ConstantRadii& law, double e) {
  const double h = std::max(0.0, law.radius - e);
  return {h, h * h};
}

Excess excess(const UniformRadii& law, double e) {
  const double width = law.hi - law.lo;
  if (e < law.lo) {
    const double h = 0.5 * (law.lo + law.hi) - e;
    return {h, h * h + width * width / 12.0};
  }
  const double h = std::max(0.0, law.hi - e);
  return {h * h / (2.0 * width), h * h * h / (3.0 * width)};
}

Excess excess(const NormalRadii& law, double e) {
  const double z = (e - law.mean) / law.sd, above = normal_beyond(z), density = density_of_normal(z);
  const double share = normal_beyond(-law.mean / law.sd);  // not truncated
  return {law.sd * (density - z * above) / share, square(law.sd) * ((1.0 + z * z) * above - z * density) / share};
}

Excess excess(const LognormalRadii& law, double e) {
  const double s = law.sigma, d = e > 0.0 ? log(e / law.median) / s : -1e3;
  const double zeroth = normal_beyond(d), first = law.median * exp(0.5 * s * s) * normal_beyond(d - s);
  const double second = square(law.median) * exp(2.0 * s * s) * normal_beyond(d - 2.0 * s);
  return {first - e * zeroth, second - 2.0 * e * first + e * e * zeroth};
}

Excess excess(const ExponentialRadii& law, double e) {
  const double above = exp(-e / law.mean);
  return {law.mean * above, 2.0 * square(law.mean) * above};
}

/// The E >= 0 at which the decreasing f falls through `value`; 0 where it is below from the start.
template <class Function>
double falls_through(const Function& f, double value) {
  if (f(0.0) <= value) return 0.0;
  double hi = 1e-9;
  while (f(hi) > value) hi *= 2.0;
  return root_between([&](double e) { return f(e) - value; }, 0.0, hi);
}

ContactOffset offset_of(double mean_square, double mean_fourth, double smooth_share) {
  return {0.5 * mean_square, mean_square > 0.0 ? mean_fourth / square(mean_square) : 0.0, smooth_share};
}

}  // namespace

ContactOffset contact_offset(const RadiusLaw& law, double n_asperities) {
  validate(law);
  if (!(n_asperities > 0.0 && n_asperities < 1e300))
    throw InvalidArgument("contact offset: " + std::to_string(n_asperities) + " asperities; must be positive");
  const auto at = [&](double e) { return std::visit([e](const auto& l) { return excess(l, e); }, law); };
  const auto lambda = [&](double e) { return 0.5 * n_asperities * at(e).first; };
  // contacts lower than `begin` have probability exp(-40), higher than `end` 1e-14
  const double begin = falls_through(lambda, 40.0), end = falls_through(lambda, 1e-14);
  const double kink = std::holds_alternative<UniformRadii>(law) ? std::get<UniformRadii>(law).lo : begin;
  constexpr int kPieces = 200;
  static const QuadratureRule rule = gauss_legendre(12, 0.0, 1.0 / kPieces);
  double mean_square = 0.0, mean_fourth = 0.0;
  const double middle = std::clamp(kink, begin, end);
  for (const auto& [from, to] : {std::pair{begin, middle}, std::pair{middle, end}}) {
    if (!(from < to)) continue;
    for (int k = 0; k < kPieces; ++k) {
      // cubes: short pieces where exp(-Lambda) begins, long ones in the tail of lognormal radii
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double x = static_cast<double>(k) / kPieces + rule.nodes[i];
        const Excess h = at(from + (to - from) * x * x * x);
        const double weight = 3.0 * x * x * (to - from) * rule.weights[i] * exp(-0.5 * n_asperities * h.first);
        mean_square += weight * n_asperities * h.first;
        mean_fourth += weight * 2.0 * n_asperities * h.second;
      }
    }
  }
  return offset_of(mean_square, mean_fourth, exp(-lambda(0.0)));
}

ContactOffset contact_offset(const Surface& surface, const Envelope& envelope, std::int64_t n_directions) {
  if (n_directions < 1) throw InvalidArgument("contact offset: " + std::to_string(n_directions) + " directions");
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0)), n = static_cast<double>(n_directions);
  double mean_square = 0.0, mean_fourth = 0.0, smooth = 0.0;
  for (std::int64_t k = 0; k < n_directions; ++k) {
    const double z = 1.0 - (2.0 * static_cast<double>(k) + 1.0) / n, s = std::sqrt((1.0 - z) * (1.0 + z));
    const SinCos azimuth = sin_cos(golden_angle * static_cast<double>(k));
    const Vector3 down = normalized(Vector3{s * azimuth.cos, s * azimuth.sin, z});
    const std::int64_t asperity = envelope.support(down).asperity;
    if (asperity < 0) {
      smooth += 1.0 / n;
      continue;
    }
    const double square_offset = norm2(cross(surface.asperities[static_cast<std::size_t>(asperity)].direction, down));
    mean_square += square_offset / n;
    mean_fourth += square(square_offset) / n;
  }
  return offset_of(mean_square, mean_fourth, smooth);
}

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
