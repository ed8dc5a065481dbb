// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdlib>

namespace bouncelab::test {

/// How often a statistical test repeats itself: a few times, which still see what is broken, or, for
/// `tools/check statistics`, which sets BOUNCELAB_STATISTICS, as often as what it claims needs.
template <class Number>
Number repetitions(Number few, Number all) {
  return std::getenv("BOUNCELAB_STATISTICS") != nullptr ? all : few;
}

/// How many of n trials of probability p succeed at least, but for once in a thousand times: the binomial distribution.
inline double fewest_of(double n, double p) {
  double k = 0.0, below = 0.0;  // below: probability of fewer than k
  for (;; k += 1.0) {
    const double log_choose = std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
    below += std::exp(log_choose + k * std::log(p) + (n - k) * std::log1p(-p));
    if (below > 1e-3) return k;
  }
}
/// And at most.
inline double most_of(double n, double p) { return n - fewest_of(n, 1.0 - p); }

}  // namespace bouncelab::test
