// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged/student_sum.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/distributions.hpp"

namespace bouncelab::fit {

Student::Student(double nu) : reach_(nu < 3.0 ? 80.0 : 12.0) {
  for (std::size_t k = 0; k <= kSteps; ++k) below_[k] = student_t_below(-reach_ + static_cast<double>(k) * step(), nu);
}

double Student::below(double t) const {
  if (t <= -reach_) return 0.0;
  if (t >= reach_) return 1.0;
  const double at = (t + reach_) / step(), k = std::floor(at);
  const auto i = std::min(static_cast<std::size_t>(k), kSteps - 1);
  return below_[i] + (at - k) * (below_[i + 1] - below_[i]);
}

Estimate estimate_of(const std::vector<Part>& parts, double outside) {
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  for (const Part& p : parts) {
    const double reach = p.student->reach() * p.se;
    lo = std::min(lo, p.middle - reach), hi = std::max(hi, p.middle + reach);
  }
  const auto below = [&](double x) {
    double sum = 0.0;
    for (const Part& p : parts)
      sum += p.weight * (p.se > 0.0 ? p.student->below((x - p.middle) / p.se) : x >= p.middle ? 1.0 : 0.0);
    return sum;
  };
  const auto quantile = [&](double p) {
    double a = lo, b = hi;
    for (int i = 0; i < 60 && b - a > 1e-12; ++i) {
      const double x = 0.5 * (a + b);
      (below(x) < p ? a : b) = x;
    }
    return 0.5 * (a + b);
  };
  Estimate e;
  e.value = quantile(0.5);
  e.ci68 = Interval{quantile(0.158655253931457), quantile(0.841344746068543)};
  e.ci95 = Interval{quantile(0.5 * outside), quantile(1.0 - 0.5 * outside)};
  e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
  return e;
}

}  // namespace bouncelab::fit
