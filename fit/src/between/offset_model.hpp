// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Recordings at one speed as a mixed linear model:
///
///   m_r = h_r' beta + u_r + random effects of its groups + e_r,   var e_r known,   var u_r = tau^2
///
/// Nothing of size n x n is ever made.
struct OffsetData {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows h_and_m;              ///< a row a recording: h_r', and m_r last
  Eigen::VectorXd variance;  ///< of e_r
  /// Up to two groupings with a random effect for each of their levels; -1: none for this recording. Empty: no such
  /// grouping. The second has the fewer levels: its matrix is inverted.
  std::array<std::vector<int>, 2> level;
  std::array<int, 2> n_levels{0, 0};

  auto h() const { return h_and_m.leftCols(n_fixed()); }
  auto m() const { return h_and_m.col(n_fixed()); }
  Eigen::Index n() const { return h_and_m.rows(); }
  Eigen::Index n_fixed() const { return h_and_m.cols() - 1; }
  /// Of a recording; -1: none.
  std::array<int, 2> levels_of(Eigen::Index r) const {
    const auto of = [&](std::size_t g) { return n_levels[g] > 0 ? level[g][static_cast<std::size_t>(r)] : -1; };
    return {of(0), of(1)};
  }
};

/// Standard deviations of the random effects: between recordings, and between the levels of the groupings.
using Deviations = std::array<double, 3>;

/// The model at given standard deviations: generalised least squares by Woodbury's identity, the larger grouping
/// eliminated first. Time n, and the cube of the number of levels of the second grouping.
class OffsetSolution {
 public:
  OffsetSolution(const OffsetData& data, const Deviations& deviations);

  /// -2 times the logarithm of the restricted likelihood, but for a constant. Source: Patterson & Thompson, Biometrika
  /// 58, 545 (1971), doi:10.1093/biomet/58.3.545; Harville, J. Am. Stat. Assoc. 72, 320 (1977),
  /// doi:10.1080/01621459.1977.10480998.
  double minus_two_log_likelihood() const { return minus_two_log_likelihood_; }
  const Eigen::VectorXd& beta() const { return beta_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// Weighted sum of squares about the fit.
  double sum_of_squares() const { return sum_of_squares_; }
  /// Predicted effect of a level of a grouping.
  double effect(std::size_t grouping, int level) const;

  struct Residual {
    double value = 0.0;  ///< how far a recording is off what the others predict of it
    double se = 0.0;     ///< of that, with its own error and tau
  };
  /// Of a recording of the data, predicted without it (the standard deviations are those of all).
  Residual without(Eigen::Index r) const;
  /// Of a recording that is not in the data. @param level  as in OffsetData
  Residual of_another(const Eigen::RowVectorXd& h, double m, double variance, const std::array<int, 2>& level) const;

 private:
  bool has(std::size_t grouping, int level) const { return active_[grouping] && level >= 0; }
  /// z' M^-1 z of the levels of a recording.
  double inverse_of(const std::array<int, 2>& level) const;

  const OffsetData& data_;
  Deviations deviations_;
  std::array<bool, 2> active_{};
  Eigen::VectorXd weights_;  ///< 1/(tau^2 + 1/a_r)
  // M = G^-1 + Z'WZ in blocks D_0, B, B', D_1, of which those on the diagonal are diagonal
  Eigen::VectorXd inverse_;        ///< of D_0
  Eigen::MatrixXd shared_;         ///< D_0^-1 B
  Eigen::MatrixXd schur_inverse_;  ///< of D_1 - B' D_0^-1 B
  double log_det_ = 0.0;
  std::array<Eigen::MatrixXd, 2> u_;  ///< M^-1 Z'W f
  Eigen::VectorXd beta_;
  Eigen::MatrixXd covariance_;
  double sum_of_squares_ = 0.0, minus_two_log_likelihood_ = 0.0;
};

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
  /// @param se  0, or of a recording that they predict, with its own error
  /// @return degrees of freedom, 1 to n less the number of fixed effects, of the error of direction' beta
  double degrees_of_freedom(const Eigen::VectorXd& direction, double se = 0.0) const;
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

/// Which groups there are. Numbers are in order of name.
struct GroupLabels {
  std::vector<std::string> names;
  std::vector<int> of_recording;  ///< -1: not known
  GroupEffect effect = GroupEffect::none;
};

/// When the recordings were made, along the campaign.
struct CampaignTimes {
  Drift drift;             ///< without the estimate
  std::vector<double> of;  ///< of each recording, about the middle, in units of the campaign's length
  bool has_drift = false;
  std::vector<Note> notes;
};

/// The recordings that reach one speed, as rows of the model.
struct Design {
  double v_mps = 0.0;
  std::vector<std::size_t> of_row;  ///< number of the recording
  double base = 0.0;                ///< of eps: what the rows' values are differences from
  OffsetData data;                  ///< of all rows. Columns: 1, contrasts of plates, drift
  GroupLabels plates, days;         ///< of_recording by row
  bool has_drift = false;
  std::size_t plate_grouping = 0, day_grouping = 0;  ///< in data
  /// Each plate has one time of its own: they are in the drift, and have no effect.
  bool plates_are_times = false;
  std::vector<Note> notes;

  /// The columns of a plate in the middle of the campaign. @param plate  -1: none
  Eigen::VectorXd of_plate(int plate) const;
};

/// eps of a recording at a speed of comparison; nullptr where it does not reach it.
const Estimate* eps_at(const RecordingSummary& summary, double v_mps);

/// @param used  numbers of the recordings
CampaignTimes times_of(const std::vector<CampaignRecording>& recordings, const std::vector<std::size_t>& used);

/// @param used  numbers of the recordings; those that reach the speed are rows
Design make_design(const std::vector<CampaignRecording>& recordings, const std::vector<std::size_t>& used,
                   const CampaignTimes& times, double v_mps);

/// Do the rows determine all columns?
bool is_determined(const OffsetData& data);

/// Some of the rows.
OffsetData rows_of(const OffsetData& data, const std::vector<Eigen::Index>& rows);

}  // namespace bouncelab::fit
