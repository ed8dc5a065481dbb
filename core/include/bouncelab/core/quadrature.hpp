// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace bouncelab {

struct QuadratureRule {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Gauss-Legendre rule with n >= 1 points on [lo, hi]; exact for polynomials up to degree 2n - 1.
/// @return nodes in ascending order; nodes and weights on [-1, 1] are good to 4e-16 for n <= 12
QuadratureRule gauss_legendre(int n, double lo, double hi);

/// A Gauss-Legendre rule known when compiling, for inner loops.
template <std::size_t n>
struct TabulatedRule {
  std::array<double, n> nodes;
  std::array<double, n> weights;
};

/// 6 points on [0, 1].
inline constexpr TabulatedRule<6> kGaussLegendre6{{0.033765242898423975, 0.16939530676686776, 0.3806904069584015,
                                                   0.6193095930415985, 0.8306046932331322, 0.966234757101576},
                                                  {0.08566224618958517, 0.1803807865240693, 0.23395696728634552,
                                                   0.23395696728634552, 0.1803807865240693, 0.08566224618958517}};

/// 12 points on [-1, 1]: the positive half of the nodes. The others are their negatives, with the same weights.
inline constexpr TabulatedRule<6> kGaussLegendre12Positive{
    {0.1252334085114689, 0.3678314989981802, 0.5873179542866175, 0.7699026741943047, 0.9041172563704749,
     0.9815606342467193},
    {0.2491470458134028, 0.2334925365383548, 0.2031674267230659, 0.1600783285433462, 0.1069393259953184,
     0.0471753363865118}};

}  // namespace bouncelab
