// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/curve_sum.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {

double normal_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

Estimate estimate_of(const std::vector<NormalPart>& parts, double lo, double hi) {
  constexpr double kReach = 8.0;
  struct Cut {
    double below = 0.0, scale = 0.0;  ///< what lies below lo; weight over what lies within
  };
  std::vector<Cut> cuts;
  double from = HUGE_VAL, to = -HUGE_VAL, total = 0.0, weights = 0.0;
  for (const NormalPart& p : parts) {
    weights += p.weight;
    const double below = normal_below((lo - p.mean) / p.sd), within = normal_below((hi - p.mean) / p.sd) - below;
    cuts.push_back({below, within > 1e-9 ? p.weight / within : 0.0});
    if (!(cuts.back().scale > 0.0)) continue;
    total += p.weight;
    from = std::min(from, std::max(lo, p.mean - kReach * p.sd));
    to = std::max(to, std::min(hi, p.mean + kReach * p.sd));
  }
  // what lies beyond altogether is said as it is
  if (!(total > 0.0) && hi < HUGE_VAL) return estimate_of(parts, -HUGE_VAL, HUGE_VAL);
  double middle = 0.0, variance = 0.0;
  for (const NormalPart& p : parts) middle += p.weight * p.mean;
  middle /= weights;
  for (const NormalPart& p : parts) variance += p.weight / weights * (p.sd * p.sd + square(p.mean - middle));
  /// Probability below x less p, and the density there.
  const auto at = [&](double x, double p) {
    double sum = 0.0, density = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (!(cuts[k].scale > 0.0)) continue;
      const double z = (x - parts[k].mean) / parts[k].sd;
      if (z < -kReach) continue;
      sum += z > kReach ? parts[k].weight : cuts[k].scale * (normal_below(z) - cuts[k].below);
      if (z < kReach) density += cuts[k].scale / parts[k].sd * exp(-0.5 * z * z);
    }
    return std::pair{sum / total - p, density / (total * std::sqrt(2.0 * kPi))};
  };
  // Newton's steps as long as they stay between the ends, which close in
  const auto quantile = [&](double p, double z) {
    double a = from, b = to, x = std::clamp(middle + z * std::sqrt(variance), a, b);
    for (int i = 0; i < 60 && b - a > 1e-12; ++i) {
      const auto [off, density] = at(x, p);
      if (std::abs(off) < 1e-9) break;
      (off < 0.0 ? a : b) = x;
      const double next = x - off / density;
      x = next > a && next < b ? next : 0.5 * (a + b);
    }
    return x;
  };
  Estimate e;
  e.value = quantile(0.5, 0.0);
  e.ci68 = Interval{quantile(0.158655253931457, -1.0), quantile(0.841344746068543, 1.0)};
  e.ci95 = Interval{quantile(0.025, -1.96), quantile(0.975, 1.96)};
  e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
  return e;
}

Estimate exp_of(const Estimate& ln) {
  Estimate e;
  e.value = exp(ln.value);
  e.ci68 = Interval{exp(ln.ci68->lo), exp(ln.ci68->hi)};
  e.ci95 = Interval{exp(ln.ci95->lo), exp(ln.ci95->hi)};
  e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
  return e;
}

}  // namespace bouncelab::fit
