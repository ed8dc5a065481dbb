// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

struct HistogramConfig {
  std::vector<double> centres_mps{0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
  /// Full width of each window; 0: the narrowest of 0.02, 0.05, 0.1, 0.2 m/s with 1000 samples in the median window.
  double width_mps = 0.1;
  std::size_t n_min = 30;  ///< fewer samples: no fit
};

/// Counts with nothing lost: every sample is in a bin, below the first edge or above the last.
struct Bins {
  std::vector<double> eps_edges;
  std::vector<std::size_t> counts;
  std::size_t underflow = 0;
  std::size_t overflow = 0;
};
Description members_of(const Bins*);

/// A normal distribution, fitted to the samples of a window, each with its timing error, by maximum likelihood.
struct NormalFit {
  Estimate mean, sd;
  double delta_aic = 0.0;                ///< AIC less that of the two exponentials: > 0: these are preferred
  std::optional<ChiSquareTest> pearson;  ///< in bins of equal probability; ndf: bins less one less parameters
  std::vector<double> expected;          ///< counts of Bins::counts that it expects
};
Description members_of(const NormalFit*);

/// p(eps) in a window of speeds: the paper's two exponentials.
///
///   p ~ exp(slope_rising (eps - peak)) below, exp(-slope_falling (eps - peak)) above the peak,
///
/// convolved with the normal timing error of each sample, fitted unbinned by maximum likelihood. Errors are by drop
/// where samples of 10 drops or more are in the window (LawFit), the law's drift within the window taken as known.
struct HistogramFit {
  FitStatus status = FitStatus::too_few_samples;
  double v_lo_mps = 0.0, v_hi_mps = 0.0;
  double v_mps = 0.0;  ///< centre of the window, where slopes and peak refer to
  std::size_t n = 0;
  DropCount drops;                                                ///< in the window, and what the errors rest on
  std::optional<Estimate> peak_eps, slope_rising, slope_falling;  ///< slopes per unit eps, both positive
  std::optional<Estimate> slope_ratio;                            ///< falling over rising: 1 if p(eps) is symmetric
  std::optional<double> loglik;
  std::optional<ChiSquareTest> pearson;  ///< in bins of equal probability
  Bins bins;
  std::vector<CurvePoint> curve;    ///< fitted density, timing error included
  std::optional<NormalFit> normal;  ///< for comparison; absent where one of the fits failed
};
Description members_of(const HistogramFit*);
/// Those of them that say what was found: window, samples, drops, peak and slopes.
Description slopes_of(const HistogramFit*);

/// Is p(eps) lopsided for sure: does the 95 % interval of the slopes' ratio leave 1 out? Absent where there is none.
std::optional<bool> slopes_differ(const HistogramFit& histogram);

/// @param law  its drift of eps(v) and of the scatter within each window is taken out before the fit, so that peak and
///             slopes refer to the window's centre; where law.law is absent the samples are taken as they are
/// @throws InvalidArgument where a centre is not positive or the width negative
std::vector<HistogramFit> fit_histograms(const RestitutionSamples& samples, const HistogramConfig& config,
                                         const LawFit& law);

/// A bin of p(eps) in a window of speeds, as a row of a table.
struct HistogramBin {
  double v_mps = 0.0, v_lo_mps = 0.0, v_hi_mps = 0.0;  ///< centre of the window, its ends
  double eps_lo = 0.0, eps_hi = 0.0;
  std::int64_t count = 0;
  double density = 0.0;  ///< count / (n (eps_hi - eps_lo)), n all samples of the window, also those outside the bins
  double sigma_density = 0.0;    ///< sqrt(count) in place of count
  std::optional<double> fitted;  ///< mean of HistogramFit::curve over the bin; absent where there is no fit
};
const RowColumns<HistogramBin>& columns_of(const HistogramBin*);

/// All bins of all windows, window by window.
Table histogram_table(const std::vector<HistogramFit>& histograms);

/// Counts of samples in a grid of speed and eps: the paper's figs. 1 and 2, top. Samples outside the grid are counted.
inline constexpr std::size_t kMostShown = 400;  ///< samples that a picture shows one by one
struct DensityPicture {
  std::vector<double> v_edges_mps;
  std::vector<double> eps_edges;
  std::vector<std::vector<std::size_t>> counts;  ///< counts[eps bin][v bin]
  std::size_t n_outside = 0;
};
Description members_of(const DensityPicture*);

/// Speeds from the smallest to the largest; eps over the central 99.8 % of the samples, widened by a tenth.
/// @param n_v, n_eps  bins at most; fewer where samples are few (about sqrt(n)). Empty picture for fewer than 2
/// samples.
DensityPicture density_picture(const RestitutionSamples& samples, std::size_t n_v = 120, std::size_t n_eps = 100);

}  // namespace bouncelab::fit
