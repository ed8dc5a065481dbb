// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ceres/jet.h>

#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {

/// Numbers that carry their derivatives (automatic differentiation), and functions of them and of plain numbers. Those
/// of Ceres' header take the C library's, whose last digits differ by processor.
template <int N>
using Jet = ceres::Jet<double, N>;

inline double value_of(double x) { return x; }
template <int N>
double value_of(const Jet<N>& x) {
  return x.a;
}

inline double exponential(double x) { return exp(x); }
template <int N>
Jet<N> exponential(const Jet<N>& x) {
  const double value = exp(x.a);
  return Jet<N>(value, value * x.v);
}

inline double logarithm(double x) { return log(x); }
template <int N>
Jet<N> logarithm(const Jet<N>& x) {
  return Jet<N>(log(x.a), x.v / x.a);
}

inline double root(double x) { return std::sqrt(x); }
template <int N>
Jet<N> root(const Jet<N>& x) {
  const double value = std::sqrt(x.a);
  return Jet<N>(value, x.v / (2.0 * value));
}

template <class T>
T square_of(const T& x) {
  return x * x;
}

/// max(x, 0) with its corner rounded over +-width: (x + sqrt(x^2 + width^2)) / 2, without cancellation below 0.
/// @param square  of the width, > 0
template <class T>
T rounded_positive(const T& x, const T& square) {
  const T r = root(x * x + square);
  if (value_of(x) >= 0.0) return 0.5 * (x + r);
  return 0.5 * square / (r - x);
}

}  // namespace bouncelab::fit
