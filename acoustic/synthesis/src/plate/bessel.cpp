// SPDX-License-Identifier: GPL-3.0-or-later
#include "plate/bessel.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::synthesis {
namespace {

/// The recurrence f_{k-1} = (2 k / x) f_k + sign f_{k+1} downwards from an even order so high that f is negligible.
struct Recurrence {
  double at_n = 0.0;
  double sum_all = 0.0;   ///< f_0 + 2 (f_1 + f_2 + ...)
  double sum_even = 0.0;  ///< f_0 + 2 (f_2 + f_4 + ...)

  Recurrence(int n, double x, double sign) {
    const double turning = std::max(static_cast<double>(n), x);
    const int begin = 2 * static_cast<int>(0.5 * (turning + 20.0 + 6.0 * std::sqrt(turning)));
    double above = 0.0, here = 1e-300;
    for (int k = begin; k >= 0; --k) {
      if (std::abs(here) > 1e250) scale(1e-250, above, here);
      const double weight = k == 0 ? 1.0 : 2.0;
      sum_all += weight * here;
      if (k % 2 == 0) sum_even += weight * here;
      if (k == n) at_n = here;
      const double below = 2.0 * k / x * here + sign * above;
      above = here;
      here = below;
    }
  }

 private:
  void scale(double by, double& above, double& here) {
    for (double* value : {&above, &here, &at_n, &sum_all, &sum_even}) *value *= by;
  }
};

}  // namespace

double bessel_j(int n, double x) {
  if (x == 0.0) return n == 0 ? 1.0 : 0.0;
  const Recurrence f(n, x, -1.0);
  return f.at_n / f.sum_even;
}

double bessel_i(int n, double x) {
  if (x == 0.0) return n == 0 ? 1.0 : 0.0;
  const Recurrence f(n, x, 1.0);
  return f.at_n / f.sum_all * exp(x);
}

}  // namespace bouncelab::synthesis
