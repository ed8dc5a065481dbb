// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/scatter_theory.hpp"

#include <algorithm>

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

std::vector<ExpectedSlopes> expected_slopes(const RestitutionLaw& law, double q, const Impacts& impacts,
                                            const std::vector<fit::HistogramFit>& windows) {
  std::vector<ExpectedSlopes> slopes;
  for (const fit::HistogramFit& window : windows) {
    const double v = window.v_mps;
    const ImpactConditions at{v, restitution(law, v), restitution_slope(law, v), 0.0};
    FluctuationSides sum;
    std::size_t n = 0;
    double path = 0.0;
    for (const Impact& impact : impacts.rows) {
      if (impact.impact == 0) path = 0.0;
      if (impact.v_mps >= window.v_lo_mps && impact.v_mps < window.v_hi_mps) {
        const FluctuationSides sides = fluctuation_sides(q, at, path);
        sum.below += sides.below;
        sum.above += sides.above;
        ++n;
      }
      const double gained = (1.0 + restitution(law, impact.v_mps)) * impact.v_mps;
      path += gained * gained;
    }
    const auto count = static_cast<double>(n);
    if (sum.below > 0.0 && sum.above > 0.0) slopes.push_back({v, n, count / sum.below, count / sum.above});
  }
  return slopes;
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
  theory.slopes = expected_slopes(config.law, theory.q, falling, windows);
  const std::vector<double> transforms = sim::probability_transforms(falling, config.law, theory.q);
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
