// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bouncelab/fit/histogram_fit.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/maximise.hpp"

namespace bouncelab::fit {

/// Error of one quantity of a window, or of its logarithm.
struct QuantityError {
  double se = 0.0;
  std::optional<double> se_independent;  ///< where se is by drop
  Interval offset68, offset95;           ///< ends of the intervals less the estimate
};

/// One density for all samples of a window, unbinned: theta = (location, log b_below, log b_above), or (location, log
/// b) where the sides are equal or the density is normal.
struct WindowFit {
  ScatterKind kind = ScatterKind::asymmetric_laplace;
  Maximum maximum;
  Eigen::VectorXd se;  ///< of theta, of independent samples
  DropCount drops;
  /// Of peak, log b_below, log b_above, log(b_below / b_above); two-sided densities only. By drop where there are
  /// enough drops, the law by which samples were moved to the centre taken as known.
  std::vector<QuantityError> errors;
};

/// @param data  at least 5 samples
WindowFit fit_window(const LawData& data, ScatterKind kind);

/// Peak, slopes and their ratio of a two-sided fit.
Estimate peak_estimate(const WindowFit& fit);
Estimate slope_estimate(const WindowFit& fit, Eigen::Index side);  ///< side 1: rising, 2: falling
Estimate slope_ratio_estimate(const WindowFit& fit);

/// Distribution function of a fit at each sample, with the sample's own timing error.
std::vector<double> probabilities_below(const LawData& data, const WindowFit& fit);

/// The density expected of the window's samples, the mean over their timing errors, from the first edge to the last:
/// each edge is a point, and between two lie an odd number, so that the middle of each bin is one. Of two-sided
/// densities and the normal.
std::vector<CurvePoint> density_curve(const LawData& data, const WindowFit& fit, const Bins& bins);

}  // namespace bouncelab::fit
