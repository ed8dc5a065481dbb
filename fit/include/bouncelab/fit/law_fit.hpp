// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Which eps(v). `series`: 1 + sum C_i A_i v^(i/10) with the orders given; `viscoelastic`: one gamma, Pade form.
enum class LawKind { series, viscoelastic, constant };

const char* to_string(LawKind kind);

/// How a confidence interval is made: from the profile likelihood, or as value -+ a multiple of the standard error.
enum class IntervalMethod { profile, covariance };

struct LawFitConfig {
  LawKind kind = LawKind::series;
  std::vector<int> orders{2, 4, 5};                    ///< of the series: distinct, among 2, 4, 5, ... 10
  IntervalMethod intervals = IntervalMethod::profile;  ///< of nodes and constants
  /// Terms of log b(v) on each side; 0: 1 below 30 samples, 1 to 3 by BIC below 20,000, from there 3 or 6 by
  /// BIC (AIC takes 6 too often: at 20,000 samples under noise 95 % intervals of A then cover 92.5 %). At most 10.
  std::size_t n_scatter_terms = 0;
  std::size_t n_goodness = 0;  ///< replicates of the Anderson-Darling test, from 100 samples on, up to 1e5; 0: none
  std::uint64_t seed = 1;      ///< of the replicates
  /// Speeds at which eps(v) is reported [m/s], > 0; empty: below which 10, 50 and 90 % of the speeds lie.
  std::vector<double> node_speeds_mps;
};

/// Two exponentials of mean b below and above the point where they join, as functions of speed: log b = sum_k c_k x^k,
/// x = log(v / v_ref); convolved with a normal part. The law is the peak of the sum, which without a normal part is
/// where the exponentials join.
struct ScatterModel {
  double v_ref_mps = 1.0;
  std::vector<double> log_below;  ///< c_k of the lower (rising) side
  std::vector<double> log_above;  ///< c_k of the upper (falling) side; equal to log_below in symmetric models
  /// Standard deviation of the normal part, over sqrt(below above); 0 in models without one.
  double normal_ratio = 0.0;
  double below(double v_mps) const;
  double above(double v_mps) const;
  double normal(double v_mps) const;
  /// Mean distance from where the exponentials join, without the normal part.
  double mean_distance(double v_mps) const;
  /// From eps(v), the density's peak, to the mean.
  double mean_minus_peak(double v_mps) const;
  /// below^2 + above^2 + normal^2.
  double variance(double v_mps) const;
};
Description members_of(const ScatterModel*);

/// Residuals in a bin of speeds.
struct ResidualBin {
  double v_mps = 0.0;  ///< median speed
  std::size_t n = 0;
  double mean_residual = 0.0;  ///< of eps - eps(v)
  double median_residual = 0.0;
  double pull = 0.0;           ///< mean score of the location over its standard error: standard normal if the law holds
  double scatter_ratio = 0.0;  ///< mean absolute residual over what the scatter model expects
};
Description members_of(const ResidualBin*);

/// Do the samples scatter as the fit says? By the probability transforms of all samples against the uniform
/// distribution.
struct AndersonDarling {
  double a2 = 0.0;
  double p_value =
      0.0;  ///< by refitting samples drawn from the fit (parametric bootstrap); at least 1/(1 + n_replicates)
  std::size_t n_replicates = 0;
};
Description members_of(const AndersonDarling*);

struct LawFit {
  FitStatus status = FitStatus::too_few_samples;
  std::optional<Note> why;  ///< of the status; absent where all is well
  LawKind kind = LawKind::series;
  std::size_t n = 0;  ///< samples used
  DropCount drops;    ///< of the samples used, and what the errors rest on
  /// Indices of samples left out: more likely lost bounces than scatter.
  std::vector<std::size_t> outliers;
  std::size_t n_parameters = 0;           ///< of law and scatter together
  std::vector<NamedEstimate> parameters;  ///< A2, A4, A5 ... | gamma | eps
  Matrix covariance;                      ///< of `parameters`
  std::vector<NodeEstimate> nodes;
  Matrix node_covariance;
  std::optional<ScatterModel> scatter;
  std::optional<double> loglik;
  std::optional<ChiSquareTest> pearson;  ///< of the probability transforms; absent below five degrees of freedom
  std::vector<ResidualBin> residuals;
  std::optional<AndersonDarling> anderson_darling;
  std::vector<Note> notes;  ///< what was asked for and could not be had
  /// Beside the smooth curve (fit_all), where it describes the mean of eps or the peak of the scatter.
  std::optional<LawMisfit> misfit;
  std::optional<RestitutionLaw> law;  ///< usable wherever a law is wanted; absent where the fit failed
};

/// Fits eps(v), the peak of the scatter: two exponentials of different slope, a normal part of free size
/// (normal-Laplace: exponentials, a normal and whatever lies between), each sample's own normal timing error, and one
/// bounce in a hundred lost, its eps anywhere from 0 to 2. Samples must be finite with v > 0 and a sigma_eps >= 0 or
/// absent (fit_all leaves the others out).
///
/// The parameters of the search are values of eps at well spread speeds, which are almost uncorrelated; A follows
/// linearly (or gamma by inversion).
///
/// From 10 drops on (a drop: equal `recording` and `drop`) standard errors are by drop: leave-one-drop-out, and
/// intervals are those of the profile likelihood with levels of Student's t for so many drops, times the ratio of that
/// standard error to the model's. They hold whatever goes on within a drop and whatever the density of the scatter.
/// With fewer drops, or where the fit depends on a single one, they come from the expected Fisher information at the
/// estimate, which exists also where the density has a kink, and hold where the scatter is as modelled and samples are
/// independent. Likelihoods, AIC and BIC are those of independent samples always.
///
/// Samples without sigma_eps are taken as free of timing noise. So that the search meets no kink, every
/// sample's timing error is widened, in quadrature, to b sqrt(p/n), b the local scatter: about the standard error of
/// the curve, which shifts the estimate by less than a hundredth of it.
/// @throws InvalidArgument where orders are not valid, another member of `config` is out of its range (FitConfig), or a
///         sample is not finite
LawFit fit_law(const RestitutionSamples& samples, const LawFitConfig& config);

}  // namespace bouncelab::fit
