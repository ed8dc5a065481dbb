// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab {

struct HistogramConfig {
  std::vector<double> centres_mps{0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
  double width_mps = 0.1;  ///< full width of each window, > 0
  std::size_t n_min = 30;  ///< fewer samples: no fit
};

/// Counts with nothing lost: every sample is in a bin, below the first edge or above the last.
struct Bins {
  std::vector<double> eps_edges;
  std::vector<std::size_t> counts;
  std::size_t underflow = 0;
  std::size_t overflow = 0;
};

/// p(eps) in a window of speeds: the paper's two exponentials.
///
///   p ~ exp(slope_rising (eps - peak)) below, exp(-slope_falling (eps - peak)) above the peak,
///
/// convolved with the normal timing error of each sample, fitted unbinned by maximum likelihood.
struct HistogramFit {
  FitStatus status = FitStatus::too_few_samples;
  std::string message;
  double v_lo_mps = 0.0, v_hi_mps = 0.0;
  double v_mps = 0.0;  ///< centre of the window, where slopes and peak refer to
  std::size_t n = 0;
  std::optional<Estimate> peak_eps, slope_rising, slope_falling;  ///< slopes per unit eps, both positive
  std::optional<double> loglik, chi2, p_value;                    ///< Pearson's chi2 in bins of equal probability
  std::optional<std::size_t> ndf;
  std::optional<double> delta_aic_gaussian;  ///< AIC(normal) - AIC(two exponentials): > 0 speaks against the normal
  Bins bins;
  std::vector<CurvePoint> curve;  ///< fitted density, timing error included
};

/// @param law  its drift of eps(v) and of the scatter within each window is taken out before the fit, so that peak and
///             slopes refer to the window's centre; where law.law is absent the samples are taken as they are
/// @throws InvalidArgument where a centre or the width is not positive
std::vector<HistogramFit> fit_histograms(const RestitutionSamples& samples, const HistogramConfig& config,
                                         const LawFit& law);

}  // namespace bouncelab
