// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/theory.hpp"

#include <algorithm>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/fluctuation.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/sim/envelope.hpp"

namespace bouncelab::loop {
namespace {

constexpr double kLargestQ = 0.1;  // of Fluctuation

bool applies(const sim::SimulationConfig& config) {
  return config.start_spin_radps == std::array<double, 3>{} && config.start_velocity_mps == std::array<double, 2>{} &&
         config.tilt_rad == 0.0 && !config.patch_plate;
}

/// Of each drop the impacts before the first that meets the ball on its way up.
Impacts falling_impacts(const Impacts& impacts) {
  Impacts falling;
  falling.rows.reserve(impacts.rows.size());
  bool ended = false;
  for (const Impact& impact : impacts.rows) {
    if (impact.impact == 0) ended = false;
    ended = ended || !(impact.v_mps > 0.0);
    if (!ended) falling.rows.push_back(impact);
  }
  return falling;
}

/// An impact and the S of its drop before it.
struct ImpactWithPath {
  double v_mps, r, path_m2ps2;
};

std::vector<ImpactWithPath> impacts_with_paths(const RestitutionLaw& law, const Impacts& impacts) {
  std::vector<ImpactWithPath> all;
  all.reserve(impacts.rows.size());
  double path = 0.0;
  for (const Impact& impact : impacts.rows) {
    if (impact.impact == 0) path = 0.0;
    const double eps = restitution(law, impact.v_mps);
    all.push_back({impact.v_mps, impact.eps_macro - eps, path});
    path += square((1.0 + eps) * impact.v_mps);
  }
  return all;
}

FluctuationSides sides_at(const RestitutionLaw& law, double q, double v_mps, double path_m2ps2) {
  return fluctuation_sides(q, {v_mps, restitution(law, v_mps), restitution_slope(law, v_mps), 0.0}, path_m2ps2);
}

std::optional<ExpectedSlopes> expected_slopes(const std::vector<FluctuationSides>& sides, double v_mps) {
  FluctuationSides sum;
  for (const FluctuationSides& s : sides) {
    sum.below += s.below;
    sum.above += s.above;
  }
  const auto count = static_cast<double>(sides.size());
  if (!(sum.below > 0.0 && sum.above > 0.0)) return std::nullopt;
  return ExpectedSlopes{v_mps, sides.size(), count / sum.below, count / sum.above};
}

void add_density(std::vector<FluctuationSides> sides, double peak_eps, const fit::Bins& bins, ExpectedDensity& result) {
  constexpr std::size_t kPoints = 160, kSides = 64;  // S is much the same in all drops: 64 of its quantiles say it all
  const double lo = bins.eps_edges.front(), hi = bins.eps_edges.back();
  for (std::size_t k = 0; k <= kPoints; ++k)
    result.eps.push_back(lo + (hi - lo) * static_cast<double>(k) / static_cast<double>(kPoints));
  if (peak_eps > lo && peak_eps < hi)  // the tip is sharp
    result.eps.insert(std::upper_bound(result.eps.begin(), result.eps.end(), peak_eps), peak_eps);
  std::sort(sides.begin(), sides.end(), [](const auto& a, const auto& b) { return a.below < b.below; });
  const std::size_t n = std::min(kSides, sides.size());
  for (const double eps : result.eps) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k)
      sum += exp(sides[(2 * k + 1) * sides.size() / (2 * n)].log_density(eps - peak_eps));
    result.density.push_back(sum / static_cast<double>(n));
  }
}

void count(double eps, const fit::Bins& bins, std::vector<std::size_t>& counts) {
  const auto next = std::upper_bound(bins.eps_edges.begin(), bins.eps_edges.end(), eps);
  if (next != bins.eps_edges.begin() && next != bins.eps_edges.end())
    ++counts[static_cast<std::size_t>(next - bins.eps_edges.begin()) - 1];
}

void add_window(const RestitutionLaw& law, const std::vector<ImpactWithPath>& impacts, const fit::HistogramFit& window,
                ScatterTheory& theory) {
  const double v = window.v_mps, peak_eps = restitution(law, v);
  std::vector<FluctuationSides> sides;
  ExpectedDensity density{v, {}, {}, 0, std::vector<std::size_t>(window.bins.counts.size(), 0)};
  for (const ImpactWithPath& impact : impacts) {
    if (!(impact.v_mps >= window.v_lo_mps && impact.v_mps < window.v_hi_mps)) continue;
    const FluctuationSides here = sides_at(law, theory.q, impact.v_mps, impact.path_m2ps2);
    sides.push_back(sides_at(law, theory.q, v, impact.path_m2ps2));
    const FluctuationSides& there = sides.back();
    // of a drop's first impact nothing lies above: it stays where it is
    const double stretch =
        impact.r < 0.0 ? there.below / here.below : (here.above > 0.0 ? there.above / here.above : 1.0);
    if (!window.bins.counts.empty()) count(peak_eps + impact.r * stretch, window.bins, density.simulated_counts);
  }
  if (const auto slopes = expected_slopes(sides, v)) theory.slopes.push_back(*slopes);
  if (sides.empty() || window.bins.counts.empty()) return;
  density.n_simulated = sides.size();
  add_density(std::move(sides), peak_eps, window.bins, density);
  theory.densities.push_back(std::move(density));
}

}  // namespace

std::optional<ScatterTheory> scatter_theory(const sim::SimulationConfig& config, const sim::ContactOffset& surface,
                                            const Impacts& impacts, const std::vector<fit::HistogramFit>& windows) {
  ScatterTheory theory;
  theory.contact_factor = sim::contact_factor(config.ball, config.contact);
  theory.offset_variance = surface.variance;
  theory.q = theory.contact_factor * theory.offset_variance;
  if (!applies(config) || !(theory.q > 0.0 && theory.q <= kLargestQ)) return std::nullopt;
  const Impacts falling = falling_impacts(impacts);
  const std::vector<ImpactWithPath> with_paths = impacts_with_paths(config.law, falling);
  for (const fit::HistogramFit& window : windows) add_window(config.law, with_paths, window, theory);
  const std::vector<double> transforms =
      sim::probability_transforms(falling, config.law, theory.q, 0.0, config.n_threads);
  theory.n_transforms = transforms.size();
  const std::size_t n_bins = theory.transform_counts.size();
  for (const double p : transforms)
    ++theory.transform_counts[std::min(n_bins - 1, static_cast<std::size_t>(p * static_cast<double>(n_bins)))];
  return theory;
}

sim::ContactOffset contact_offset_of(const Ball& ball, const sim::Surface* given, const sim::RadiusLaw& law,
                                     std::int64_t n_asperities, int n_threads) {
  if (given != nullptr) return sim::contact_offset(*given, sim::Envelope(ball, *given, n_threads));
  return n_asperities > 0 ? sim::contact_offset(law, static_cast<double>(n_asperities)) : sim::ContactOffset{};
}

}  // namespace bouncelab::loop
