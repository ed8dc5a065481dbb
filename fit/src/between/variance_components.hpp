// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "between/offset_model.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Standard deviations between recordings and groups by restricted maximum likelihood, from 0 on, one after the other
/// until none moves. Groupings without levels, or asked to be left out, are 0.
Deviations restricted_maximum(const OffsetData& data);

/// 95 % interval of one of them by the profile of the restricted likelihood: where -2 ln L is above its least by the
/// square of Student's t for the recordings less the fixed effects (3.84 of many), the others at their best. 0 where it
/// never rises so far below.
Interval profile_interval(const OffsetData& data, const Deviations& best, std::size_t k);

/// How well errors of the fixed effects are known: degrees of freedom of Student's t by Satterthwaite's method, from
/// the curvature of the restricted likelihood by the logarithms of the variances. Source: Fai & Cornelius, J. Stat.
/// Comput. Simul. 54, 363 (1996), doi:10.1080/00949659608811740.
class ErrorsOfErrors {
 public:
  ErrorsOfErrors(const OffsetData& data, const Deviations& best);
  /// @return degrees of freedom, 1 to n less the number of fixed effects, of the error of direction' beta
  double degrees_of_freedom(const Eigen::VectorXd& direction) const;
  /// Likewise of the error of a recording that they predict. @param se  of the prediction, with its own error
  double degrees_of_freedom(const Eigen::VectorXd& direction, double se) const;
  /// Of the error of a recording against the others, when tau is most of what is not known of that error.
  double degrees_of_freedom_of_a_recording(double se) const;

 private:
  double satterthwaite(const Eigen::VectorXd& gradient, double variance) const;

  double most_;
  std::vector<double> variances_;             ///< those of which the derivatives are
  bool tau_is_first_ = false;                 ///< among them
  Eigen::MatrixXd covariance_;                ///< of beta
  std::vector<Eigen::MatrixXd> derivatives_;  ///< of that by the logarithms of the variances
  Eigen::MatrixXd covariance_of_logs_;
};

}  // namespace bouncelab::fit
