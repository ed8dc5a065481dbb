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

// excess: int_E^inf (r - E) p(r) dr.
double normal_beyond(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

double excess(const ConstantRadii& law, double e) { return std::max(0.0, law.radius - e); }
double excess(const UniformRadii& law, double e) {
  if (e < law.lo) return 0.5 * (law.lo + law.hi) - e;
  return square(std::max(0.0, law.hi - e)) / (2.0 * (law.hi - law.lo));
}
double excess(const NormalRadii& law, double e) {
  const double z = (e - law.mean) / law.sd,
               density = exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
  const double share = normal_beyond(-law.mean / law.sd);  // not truncated
  return law.sd * (density - z * normal_beyond(z)) / share;
}
double excess(const LognormalRadii& law, double e) {
  const double s = law.sigma, d = e > 0.0 ? log(e / law.median) / s : -1e3;
  return law.median * exp(0.5 * s * s) * normal_beyond(d - s) - e * normal_beyond(d);
}
double excess(const ExponentialRadii& law, double e) { return law.mean * exp(-e / law.mean); }
/// The E >= 0 at which the decreasing f falls through `value`; 0 where it is below from the start.
template <class Function>
double falls_through(const Function& f, double value) {
  if (f(0.0) <= value) return 0.0;
  double hi = 1e-9;
  while (f(hi) > value) hi *= 2.0;
  return root_between([&](double e) { return f(e) - value; }, 0.0, hi);
}

}  // namespace

ContactOffset contact_offset(const RadiusLaw& law, double n_asperities) {
  validate(law);
  if (!(n_asperities > 0.0 && n_asperities < 1e300))
    throw InvalidArgument("contact offset: " + std::to_string(n_asperities) + " asperities; must be positive");
  const auto lambda = [&](double e) {
    return 0.5 * n_asperities * std::visit([e](const auto& l) { return excess(l, e); }, law);
  };
  // contacts lower than `begin` have probability exp(-40), higher than `end` 1e-14
  const double begin = falls_through(lambda, 40.0), end = falls_through(lambda, 1e-14);
  const double kink = std::holds_alternative<UniformRadii>(law) ? std::get<UniformRadii>(law).lo : begin;
  constexpr int kPieces = 200;
  static const QuadratureRule rule = gauss_legendre(12, 0.0, 1.0 / kPieces);
  double variance = 0.0;
  const double middle = std::clamp(kink, begin, end);
  for (const auto& [from, to] : {std::pair{begin, middle}, std::pair{middle, end}}) {
    if (!(from < to)) continue;
    for (int k = 0; k < kPieces; ++k) {
      // cubes: short pieces where exp(-Lambda) begins, long ones in the tail of lognormal radii
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double x = static_cast<double>(k) / kPieces + rule.nodes[i];
        const double higher = lambda(from + (to - from) * x * x * x);
        variance += 3.0 * x * x * (to - from) * rule.weights[i] * higher * exp(-higher);
      }
    }
  }
  return {variance, exp(-lambda(0.0))};
}

ContactOffset contact_offset(const Surface& surface, const Envelope& envelope, std::int64_t n_directions) {
  if (n_directions < 1) throw InvalidArgument("contact offset: " + std::to_string(n_directions) + " directions");
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0)), n = static_cast<double>(n_directions);
  ContactOffset offset;
  for (std::int64_t k = 0; k < n_directions; ++k) {
    const double z = 1.0 - (2.0 * static_cast<double>(k) + 1.0) / n, s = std::sqrt((1.0 - z) * (1.0 + z));
    const SinCos azimuth = sin_cos(golden_angle * static_cast<double>(k));
    const Vector3 down = normalized(Vector3{s * azimuth.cos, s * azimuth.sin, z});
    const std::int64_t asperity = envelope.support(down).asperity;
    if (asperity < 0)
      offset.smooth_share += 1.0 / n;
    else
      offset.variance += 0.5 / n * norm2(cross(surface.asperities[static_cast<std::size_t>(asperity)].direction, down));
  }
  return offset;
}

double contact_factor(const Ball& ball, const ContactModel& model) {
  const double k = mass_kg(ball) * square(ball.radius_m) / moment_of_inertia_kgm2(ball);
  const auto* coulomb = std::get_if<CoulombContact>(&model);
  const auto* stronge = std::get_if<StrongeContact>(&model);
  const bool slips = std::holds_alternative<FrictionlessContact>(model) || (coulomb && coulomb->mu == 0.0) ||
                     (stronge && stronge->mu == 0.0);
  return slips ? k : k / (1.0 + k);
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
