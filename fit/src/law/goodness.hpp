// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "law/law_likelihood.hpp"

namespace bouncelab::fit {

struct ChiSquare {
  double chi2 = 0.0;
  std::size_t ndf = 0;
  double p_value = 0.0;  ///< probability of a larger chi2
};

/// Pearson's chi2 of probability transforms u (uniform if the model holds), in order of speed: cells of equal
/// expectation, up to 10 in u by up to 40 in speed, at least 8 samples each. Parameters fitted to the samples, not to
/// the cells, cost between none and all of their degrees of freedom (Chernoff & Lehmann, Ann. Math. Stat. 25, 579
/// (1954), doi:10.1214/aoms/1177728726): all are subtracted where they are less than a tenth of the cells and the
/// difference is small, none otherwise, which makes p too large rather than too small. nullopt where samples are too
/// few for one degree of freedom.
/// @param n_groups_most  1: cells in u alone, up to 30
std::optional<ChiSquare> pearson_chi2(const std::vector<double>& u, std::size_t n_parameters,
                                      std::size_t n_groups_most = 40);

/// Residuals in up to 24 bins of speed with equal counts.
std::vector<ResidualBin> residual_bins(const LawLikelihood& likelihood, const Eigen::VectorXd& theta);

}  // namespace bouncelab::fit
