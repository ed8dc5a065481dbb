// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// Samples that are to be compared with those of other groups.
struct UnitGroup {
  const RestitutionSamples* samples;
  const std::vector<std::size_t>* outliers;  ///< their places, rising: left out
  const ScatterModel* scatter;               ///< of the group; with the timing the variance of a sample
};

/// Samples by unit: columns of equal length.
struct UnitSamples {
  std::vector<double> residual;          ///< of eps from a curve of all
  std::vector<double> weight;            ///< 1 / variance of the scatter and of the timing, but for a factor
  Eigen::MatrixXd curve;                 ///< a row a sample: what may be wrong about the curve, as d eps
  std::vector<std::size_t> group, unit;  ///< each sample's, from 0, none left out; a unit is of one group
  std::size_t n_groups = 0, n_units = 0;
};

/// The table: residuals from a law, and what may be wrong about that.
/// @param law            with `law` and parameters
/// @param of_recordings  a unit is a recording, else a drop
UnitSamples unit_samples(const std::vector<UnitGroup>& groups, const LawFit& law, std::vector<int> orders,
                         bool of_recordings);

/// Means of the units, a constant of eps for each beside one curve by weighted least squares, and what they leave.
struct UnitMeans {
  std::vector<double> mean, weight;  ///< of each unit: its offset from the curve; the sum of its samples' weights
  double squares = 0.0;              ///< weighted sum of squares about curve and means
  std::size_t n_free = 0;            ///< its degrees of freedom
};
/// @param unit  of each sample: samples.group, samples.unit
UnitMeans unit_means(const UnitSamples& samples, const std::vector<std::size_t>& unit, std::size_t n_units);

}  // namespace bouncelab::fit
