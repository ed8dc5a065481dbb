// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/quadrature.hpp"

#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab {

QuadratureRule gauss_legendre(int n, double lo, double hi) {
  QuadratureRule rule;
  for (int k = 0; k < n; ++k) {
    double x = -cos(std::numbers::pi * (k + 0.75) / (n + 0.5));  // within Newton's reach of the root
    double derivative = 0.0;
    for (int iteration = 0; iteration < 5; ++iteration) {
      double p = 1.0, p_before = 0.0;
      for (int j = 1; j <= n; ++j) {
        const double next = ((2.0 * j - 1.0) * x * p - (j - 1.0) * p_before) / j;
        p_before = p;
        p = next;
      }
      derivative = n * (x * p - p_before) / (x * x - 1.0);
      x -= p / derivative;
    }
    rule.nodes.push_back(0.5 * (lo + hi) + 0.5 * (hi - lo) * x);
    rule.weights.push_back((hi - lo) / ((1.0 - x * x) * derivative * derivative));
  }
  return rule;
}

}  // namespace bouncelab
