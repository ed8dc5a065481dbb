// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// Samples at the plate as columns, drop by drop, with their derivatives by the deviations of drag and contact time
/// that are open: a column of ln kappa and one of ln tau, each where it is open.
struct PlateSamples {
  /// Rows of one drop, in the order of its impacts: `n` from `begin` on. Long drops are cut, since a covariance of all
  /// their rows would take the cube of their number.
  struct Piece {
    Eigen::Index begin = 0, n = 0;
  };
  std::vector<Piece> pieces;
  std::size_t n_drops = 0;
  Eigen::VectorXd x;  ///< ln v, v in m/s
  Eigen::VectorXd eps;
  Eigen::MatrixXd dx, deps;  ///< derivatives by the deviations
  Eigen::VectorXd impact;    ///< its number within the drop
  Eigen::VectorXd excess;    ///< what noisy times add to eps on average
  bool timing_is_least = false;
  /// Variance of eps by the times, covariance with the next row of the piece, with the one after that.
  Eigen::MatrixXd timing;
  Eigen::VectorXd ln_jacobian;  ///< ln d eps / d (T'/T): density of eps to that of the intervals

  Eigen::Index size() const { return x.size(); }
};

/// @param at  where the derivatives are taken
PlateSamples plate_samples(const RestitutionSamples& samples, const AirAndContact& known, Deviation at);

/// Whole pieces, evenly spread, with at most `most` rows or one piece.
std::vector<Eigen::Index> rows_of_some(const PlateSamples& samples, Eigen::Index most);
/// Those rows, which are whole pieces.
PlateSamples part_of(const PlateSamples& samples, const std::vector<Eigen::Index>& rows);

/// How eps scatters about the curve: s (v/v_m)^-p from bounce to bounce, v_m the median speed, and what the bounces of
/// one drop share, rho times that, with a correlation phi from bounce to bounce (1: a loss of the drop's own).
struct Noise {
  double ln_s = 0.0, power = 0.0, rho = 0.0, phi = 1.0;
  double ln_prior = 0.0;  ///< of power, rho, phi and timing
  double timing = 1.0;    ///< standard errors of times and heights over those stated
  /// Of one bounce of one of many drops, without errors of its times. @param ln_ratio  ln v/v_m
  double variance(double ln_ratio) const;
};

/// One noise with the s that is most likely.
struct LikelyNoise {
  Noise noise;
  double ln_s_sd = 1.0;      ///< width of the likelihood in ln s
  double ln_evidence = 0.0;  ///< at that s, with the prior
};

/// X^T C^-1 X of columns X, C the covariance of the samples by noise and timing, and ln det C.
struct Gram {
  Eigen::MatrixXd of;
  double ln_det = 0.0;
  double timing2 = 1.0;      ///< square of the noise's timing
  double ln_jacobian = 0.0;  ///< of all these samples
};
/// @param inflation  a row each: of the variance of one bounce, 1 but of outliers
/// @param x_middle   ln v_m
Gram gram_of(const PlateSamples& samples, double x_middle, const Eigen::VectorXd& inflation,
             const Eigen::MatrixXd& columns, const Noise& noise);

/// How often each is met in n equal steps through all of the weights, whose sum is 1.
std::vector<double> met_in_steps(const std::vector<double>& weights, double n);

/// ln of the prior of s, without a constant.
double ln_prior_of_s(double ln_s);

/// The s that makes ln_evidence + ln_prior largest, by steps that halve to the width that n samples leave.
LikelyNoise with_likely_s(Noise noise, double step, std::size_t n, const std::function<double(const Noise&)>& evidence);

/// All noises within `kLikely` of the best: powers 0, 1/2, 1, and of several drops what they share.
/// @param timings  factors of standard errors that may be too small, and what each counts beforehand
std::vector<LikelyNoise> likely_noises(const LikelyNoise& first, const std::vector<std::pair<double, double>>& timings,
                                       std::size_t n_drops, std::size_t n,
                                       const std::function<double(const Noise&)>& evidence);

}  // namespace bouncelab::fit
