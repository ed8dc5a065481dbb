// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {

const char* to_string(FitStatus status) {
  switch (status) {
    case FitStatus::ok:
      return "ok";
    case FitStatus::not_identifiable:
      return "not_identifiable";
    case FitStatus::not_applicable:
      return "not_applicable";
    case FitStatus::not_converged:
      return "not_converged";
    case FitStatus::too_few_samples:
      return "too_few_samples";
  }
  return "unknown";
}

const char* to_string(ErrorBasis basis) {
  switch (basis) {
    case ErrorBasis::independent_samples:
      return "independent_samples";
    case ErrorBasis::by_sample:
      return "by_sample";
    case ErrorBasis::by_drop:
      return "by_drop";
  }
  return "unknown";
}

Estimate normal_estimate(double value, double se, double reach68, double reach95) {
  Estimate estimate;
  estimate.value = value;
  estimate.se = se;
  estimate.ci68 = Interval{value - reach68 * se, value + reach68 * se};
  estimate.ci95 = Interval{value - reach95 * se, value + reach95 * se};
  return estimate;
}

std::string in_words(double value, std::optional<double> se) {
  char text[64];
  if (!se || !(*se > 0.0) || !std::isfinite(*se)) {
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
  }
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(log10(*se))), 0, 12);
  std::snprintf(text, sizeof text, "%.*f ± %.*f", decimals, value, decimals, *se);
  return text;
}

}  // namespace bouncelab::fit
