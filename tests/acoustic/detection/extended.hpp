// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <optional>

#include "tracking/hypothesis.hpp"

namespace bouncelab::test {

/// A hypothesis with one more impact, after n_missing that were not detected; absent where no ball does that, or below
/// the least log odds.
inline std::optional<detection::Hypothesis> extended(const detection::Hypothesis& h, const detection::Observation& next,
                                                     int n_missing, double same_source, bool is_counted,
                                                     double least_log_odds = -INFINITY) {
  const auto step = h.step_to(next, n_missing, same_source, is_counted, least_log_odds);
  if (!step) return {};
  std::optional<detection::Hypothesis> longer = h;
  longer->take(*step, next);
  return longer;
}

}  // namespace bouncelab::test
