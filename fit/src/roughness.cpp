// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/memory_fit.hpp"

#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/fit/usable_samples.hpp"

namespace bouncelab::fit {

Roughness equivalent_surfaces(const Estimate& q, double inertia_factor) {
  if (!(inertia_factor > 0.0 && inertia_factor <= 1.0))
    throw InvalidArgument("inertia factor J/(m R^2) = " + std::to_string(inertia_factor) + ": must be in (0, 1]");
  Roughness r;
  r.q = q;
  r.inertia_factor = inertia_factor;
  r.s2_no_slip = q.value * (1.0 + inertia_factor);
  r.s2_frictionless = q.value * inertia_factor;
  r.rms_tilt_no_slip_deg = std::sqrt(2.0 * r.s2_no_slip) * 180.0 / std::numbers::pi;
  r.n_constant_radii = 2.0 / r.s2_no_slip;
  r.lambda_exponential = r.s2_no_slip;
  r.width_uniform_1e6 = 4e6 * square(r.s2_no_slip) / std::numbers::pi;
  return r;
}

RoughnessResult measure_roughness(const RestitutionSamples& samples, const RoughnessConfig& config) {
  RoughnessResult result;
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  const RestitutionSamples& used = *part;
  with_threads(config.n_threads, [&] {
    LawFitConfig start;
    start.intervals = IntervalMethod::covariance;
    start.seed = config.seed;
    const LawFit independent = fit_law(used, start);
    MemoryFitConfig memory;
    memory.seed = config.seed;
    memory.n_goodness = config.n_goodness;
    for (const NodeEstimate& node : independent.nodes) memory.node_speeds_mps.push_back(node.v_mps);
    result.memory = fit_memory(used, independent, memory);
    if (!independent.outliers.empty()) left_out.n["outlier"] = independent.outliers.size();
  });
  result.n_left_out = left_out.n;
  return result;
}

Estimate leak_of(const MemoryFit& memory) {
  const auto reversed = [](std::optional<Interval>& i) {
    if (i) i = Interval{1.0 - i->hi, 1.0 - i->lo};
  };
  Estimate leak = memory.keep;
  leak.value = 1.0 - leak.value;
  reversed(leak.ci68);
  reversed(leak.ci95);
  return leak;
}

}  // namespace bouncelab::fit
