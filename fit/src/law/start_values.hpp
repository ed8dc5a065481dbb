// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "law/law_likelihood.hpp"

namespace bouncelab::fit {

/// Robust first look at the samples of a law, whatever the family of the scatter: medians of eps in bins of equal
/// count, the curve through them by least squares, scales of the scatter in each bin from the distances to it.
struct FirstLook {
  Eigen::VectorXd law;                   ///< q
  std::vector<double> v_mps;             ///< of the bins
  Eigen::VectorXd log_below, log_above;  ///< in each bin; one for all of few samples
};
/// @return nothing where the law cannot be made to pass (eps >= 1 in a viscoelastic law)
std::optional<FirstLook> first_look(const LawData& data, const LawModel& model);

/// The whole theta of `scatter`.
Eigen::VectorXd start_values(const FirstLook& look, const ScatterFamily& scatter);
/// Of its first look, empty where there is none.
Eigen::VectorXd start_values(const LawData& data, const LawModel& model, const ScatterFamily& scatter);

/// Of two exponentials half of the variance to a normal part: both can be seen from there.
Eigen::VectorXd with_normal_part(const Eigen::VectorXd& exponentials, const ScatterFamily& scatter, Eigen::Index n_law);

}  // namespace bouncelab::fit
