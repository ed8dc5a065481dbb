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

/// Profile-likelihood intervals of direction . theta: where the likelihood, maximised over all else, has fallen by
/// z^2/2, z = 1 and 1.96. The signed root of twice the fall is nearly linear in the quantity: it is computed at 1, 2
/// (4, 8) standard errors on each side and interpolated by a parabola, error of an end about 1 % of the standard error.
/// @param white      theta = maximum.x + white y makes the likelihood about exp(-y^2/2)
/// @param direction  gradient of the quantity by theta
/// @return nullopt where the likelihood does not fall by 1.92 within 8 standard errors, or a search fails
std::optional<ProfileIntervals> profile_intervals(const LogLikelihood& loglik, const Maximum& maximum,
                                                  const Eigen::MatrixXd& white, const Eigen::VectorXd& direction);

}  // namespace bouncelab::fit
