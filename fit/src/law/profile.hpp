// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "bouncelab/fit/estimate.hpp"
#include "law/maximise.hpp"

namespace bouncelab::fit {

/// Distances of the ends of the intervals from the estimate, lo negative.
struct ProfileIntervals {
  Interval offset68, offset95;
};

/// How far the likelihood falls to the ends of intervals, as the signed root of twice the fall.
struct ProfileLevels {
  double z68 = 1.0, z95 = 1.959963984540054;  ///< of very many samples
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

}  // namespace bouncelab::fit
