// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "law/law_likelihood.hpp"

namespace bouncelab::fit {

/// Robust first guess: medians of eps in bins of equal count, curve through them by least squares; scatter from mean
/// distances to it. Gives the whole theta of `scatter`. Empty where the law cannot be made to pass (eps >= 1 in a
/// viscoelastic law).
Eigen::VectorXd start_values(const LawData& data, const LawModel& model, const ScatterFamily& scatter);

/// Of two exponentials half of the variance to a normal part: both can be seen from there.
Eigen::VectorXd with_normal_part(const Eigen::VectorXd& exponentials, const ScatterFamily& scatter, Eigen::Index n_law);

/// Widens every sample's timing error, in quadrature, to width * b, b the mean of both sides' scales at its speed.
void widen(LawData& data, const ScatterModel& scatter, double width);

}  // namespace bouncelab::fit
