// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/fit/recordings.hpp"

namespace bouncelab::fit {

/// Samples by unit: columns of equal length.
struct UnitSamples {
  std::vector<double> residual;          ///< of eps from a curve of all
  std::vector<double> weight;            ///< 1 / variance of the scatter and of the timing, but for a factor
  Eigen::MatrixXd curve;                 ///< a row a sample: what may be wrong about the curve, as d eps
  std::vector<std::size_t> group, drop;  ///< each sample's, from 0, none left out; a drop is of one group
  std::size_t n_groups = 0, n_drops = 0;
};

/// Means of the units, a constant of eps for each beside one curve by weighted least squares, and what they leave.
struct UnitMeans {
  std::vector<double> mean, weight;  ///< of each unit: its offset from the curve; the sum of its samples' weights
  double squares = 0.0;              ///< weighted sum of squares about curve and means
  std::size_t n_free = 0;            ///< its degrees of freedom
};
UnitMeans unit_means(const UnitSamples& samples, const std::vector<std::size_t>& unit, std::size_t n_units);

struct Agreement {
  RecordingsTest test;
  std::vector<Estimate> offsets;  ///< of each group, their mean over all samples 0
};

/// Do the groups differ by more than what is within them? See RecordingsTest.
/// @return absent where fewer than two groups can be told from the curve
std::optional<Agreement> agreement(const UnitSamples& samples);

}  // namespace bouncelab::fit
