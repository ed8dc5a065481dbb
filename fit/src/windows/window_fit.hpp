// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bouncelab/fit/histogram_fit.hpp"
#include "law/law_likelihood.hpp"
#include "law/maximise.hpp"
#include "law/profile.hpp"

namespace bouncelab::fit {

/// One density for all samples of a window, unbinned: theta = (location, log b_below, log b_above), or (location, log
/// b) where the sides are equal or the density is normal.
struct WindowFit {
  Maximum maximum;
  Eigen::MatrixXd covariance;
  /// Of peak, log b_below, log b_above, log(b_below / b_above); two-sided densities only.
  std::vector<std::optional<ProfileIntervals>> profiles;
};

/// @param data  at least 5 samples
WindowFit fit_window(const LawData& data, ScatterKind kind);

/// Peak, slopes and their ratio of a two-sided fit.
Estimate peak_estimate(const WindowFit& fit);
Estimate slope_estimate(const WindowFit& fit, Eigen::Index side);  ///< side 1: rising, 2: falling
Estimate slope_ratio_estimate(const WindowFit& fit);

/// The density expected of the window's samples, the mean over their timing errors, from the first edge to the last.
std::vector<CurvePoint> density_curve(const LawData& data, const Eigen::VectorXd& theta, const Bins& bins);

}  // namespace bouncelab::fit
