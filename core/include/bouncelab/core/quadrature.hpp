// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace bouncelab {

struct QuadratureRule {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Gauss-Legendre rule with n points on [lo, hi].
QuadratureRule gauss_legendre(int n, double lo, double hi);

}  // namespace bouncelab
