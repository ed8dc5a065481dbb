// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "curve/plate_samples.hpp"

namespace bouncelab::fit {

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
  double timing2 = 1.0;                ///< square of the noise's timing
  double ln_jacobian = 0.0;            ///< of all these samples
  Eigen::VectorXd ln_jacobian_slopes;  ///< by the deviations
};
/// @param inflation  a row each: of the variance of one bounce, 1 but of outliers
/// @param x_middle   ln v_m
Gram gram_of(const PlateSamples& samples, double x_middle, const Eigen::VectorXd& inflation,
             const Eigen::MatrixXd& columns, const Noise& noise);

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
