// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Student's distribution function, tabulated: a sum of thousands is asked for hundreds of times.
class Student {
 public:
  explicit Student(double nu);
  double below(double t) const;
  /// Beyond it there is 1e-4 or less.
  double reach() const { return reach_; }

 private:
  static constexpr std::size_t kSteps = 4000;
  double step() const { return 2.0 * reach_ / static_cast<double>(kSteps); }
  double reach_;
  std::array<double, kSteps + 1> below_{};
};

/// A Student distribution with its weight.
struct Part {
  double weight, middle, se;
  const Student* student;
};

/// Quantiles of a sum of distributions, and value with errors by them.
/// @param outside  share of the sum that ci95 leaves out
Estimate estimate_of(const std::vector<Part>& parts, double outside = 0.05);

}  // namespace bouncelab::fit
