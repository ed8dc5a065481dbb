// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "bouncelab/core/numerics.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {

/// Distances of the ends of the intervals from the estimate, lo negative.
struct ProfileIntervals {
  Interval offset68, offset95;
};

/// How far the likelihood falls to the ends of intervals, as the signed root of twice the fall.
struct ProfileLevels {
  double z68 = 1.0, z95 = kNormal95;  ///< of very many samples
};
/// Of n samples about a curve of n_location parameters whose scatter is not known: where the likelihood of normal
/// scatter is at the ends of the exact interval by Student's t, z^2 = n log(1 + t^2 / (n - n_location)). A curve
/// through all samples has the levels of one degree of freedom.
ProfileLevels profile_levels(std::size_t n, std::size_t n_location);

/// Profile-likelihood intervals of direction . theta: where the likelihood, maximised over all else, has fallen to the
/// levels. The signed root of twice the fall is nearly linear in the quantity where there are many samples: on each
/// side it is computed near the level of 68 %, from there by secants up to the level of 95 %, and interpolated by a
/// parabola; where its nearest value is not within a quarter of the level once more there. Error of an end below 1 % of
/// the standard error.
/// @param white      theta = maximum.x + white y makes the likelihood about exp(-y^2/2)
/// @param direction  gradient of the quantity by theta
/// @param curvature  of the log-likelihood by y, sign reversed, where it is known: the others follow by Newton's method
/// @return nullopt where the likelihood does not fall to the level of 95 % within 200 standard errors, or a search
///         fails
std::optional<ProfileIntervals> profile_intervals(const LogLikelihood& loglik, const Maximum& maximum,
                                                  const Eigen::MatrixXd& white, const Eigen::VectorXd& direction,
                                                  const ProfileLevels& levels = {},
                                                  const Eigen::MatrixXd* curvature = nullptr);

/// What the estimates would be without each of the drops, by one Newton step (jackknife by drop): in coordinates in
/// which the model's own covariance is the unit matrix
///
///   theta_(-d) - theta = -H^-1 (1 - L_d)^-1 s_d,   covariance = (M - 1)/M sum_d (theta_(-d) - theta)(theta_(-d) -
///   theta)^T
///
/// s_d score of drop d, L_d its expected information (the share that the drop has in what is known), H observed
/// information of all M drops and the penalty. Holds whatever goes on within a drop and whatever the density of the
/// scatter; drops must be independent of each other. (1 - L_d)^-1 takes out the bias of the plain sandwich, whose
/// scores are too small by what each drop takes from the fit; the observed information of single drops would be mostly
/// noise. Sources: Liang & Zeger, Biometrika 73, 13 (1986), doi:10.1093/biomet/73.1.13; Bell & McCaffrey, Survey
/// Methodology 28, 169 (2002); MacKinnon, Nielsen & Webb, J. Appl. Econometrics 38, 671 (2023), doi:10.1002/jae.2969.
struct JackknifeErrors {
  Eigen::MatrixXd moves;      ///< theta_(-d) - theta, a column a drop
  Eigen::MatrixXd curvature;  ///< H in those coordinates
  Eigen::MatrixXd covariance() const;
  /// Of the quantity whose gradient by theta is `direction`.
  double standard_error(const Eigen::VectorXd& direction) const;
  /// Multiples of the standard error that 68.27 and 95 % intervals reach: Student's t with M - 1 degrees of freedom.
  ProfileLevels reach() const;
  /// Levels of the profile likelihood for intervals by drop: the reach times the ratio of the standard error by drop to
  /// the model's. The signed root of the profile so scaled is that of the adjusted composite likelihood.
  /// Source: Pace, Salvan & Sartori, Statistica Sinica 21, 129 (2011).
  ProfileLevels profile_levels_of(const Eigen::VectorXd& direction, const Eigen::MatrixXd& white) const;
};

/// At the maximum theta. @param white  the model's own covariance is white white^T
/// @return nullopt for fewer than kFewestDrops drops, and where the fit depends on a single drop: more than nine tenths
///         of what is known of some combination of parameters would be gone with it
std::optional<JackknifeErrors> errors_by_drop(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                              const Eigen::MatrixXd& white);

/// The same with single samples in the place of drops: errors that hold whatever the density of the scatter, if samples
/// are independent. @return nullopt for fewer than 30 samples a parameter
std::optional<JackknifeErrors> errors_by_sample(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                                const Eigen::MatrixXd& white);

}  // namespace bouncelab::fit
