// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/normal_sum.hpp"

#include <algorithm>
#include <cmath>

namespace bouncelab::fit {

double normal_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

Estimate estimate_of(const std::vector<NormalPart>& parts, double lo, double hi) {
  constexpr double kReach = 8.0;
  struct Cut {
    double below = 0.0, scale = 0.0;  ///< what lies below lo; weight over what lies within
  };
  std::vector<Cut> cuts;
  double from = HUGE_VAL, to = -HUGE_VAL, total = 0.0;
  for (const NormalPart& p : parts) {
    const double below = normal_below((lo - p.mean) / p.sd), within = normal_below((hi - p.mean) / p.sd) - below;
    cuts.push_back({below, within > 1e-9 ? p.weight / within : 0.0});
    if (!(cuts.back().scale > 0.0)) continue;
    total += p.weight;
    from = std::min(from, std::max(lo, p.mean - kReach * p.sd));
    to = std::max(to, std::min(hi, p.mean + kReach * p.sd));
  }
  // what lies beyond altogether is said as it is
  if (!(total > 0.0) && hi < HUGE_VAL) return estimate_of(parts, -HUGE_VAL, HUGE_VAL);
  const auto below = [&](double x) {
    double sum = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (cuts[k].scale > 0.0) {
        const double z = (x - parts[k].mean) / parts[k].sd;
        sum += z > kReach ? parts[k].weight : z < -kReach ? 0.0 : cuts[k].scale * (normal_below(z) - cuts[k].below);
      }
    return sum / total;
  };
  const auto quantile = [&](double p) {
    double a = from, b = to;
    for (int i = 0; i < 60 && b - a > 1e-12; ++i) {
      const double x = 0.5 * (a + b);
      (below(x) < p ? a : b) = x;
    }
    return 0.5 * (a + b);
  };
  Estimate e;
  e.value = quantile(0.5);
  e.ci68 = Interval{quantile(0.158655253931457), quantile(0.841344746068543)};
  e.ci95 = Interval{quantile(0.025), quantile(0.975)};
  e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
  return e;
}

}  // namespace bouncelab::fit
