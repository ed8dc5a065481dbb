// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Rows as a result has them.
Matrix to_matrix(const Eigen::MatrixXd& m);

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

}  // namespace bouncelab::fit
