// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {

/// Pearson's chi2 of probability transforms u (uniform if the model holds), in order of speed: cells of equal
/// expectation, up to 10 in u by up to 40 in speed, at least 8 samples each. Parameters fitted to the samples, not to
/// the cells, cost between none and all of their degrees of freedom (Chernoff & Lehmann, Ann. Math. Stat. 25, 579
/// (1954), doi:10.1214/aoms/1177728726): all are subtracted where they are less than a tenth of the cells and the
/// difference is small, none otherwise, which makes p too large rather than too small. nullopt where samples are too
/// few for one degree of freedom.
/// @param n_groups_most  1: cells in u alone, up to 30
std::optional<ChiSquareTest> pearson_chi2(const std::vector<double>& u, std::size_t n_parameters,
                                          std::size_t n_groups_most = 40);

/// Residuals in up to 24 bins of speed with equal counts.
std::vector<ResidualBin> residual_bins(const LawLikelihood& likelihood, const Eigen::VectorXd& theta);

/// A^2 of probability transforms against the uniform distribution,
///
///   A^2 = -n - (1/n) sum_i (2i - 1) [log u_(i) + log(1 - u_(n+1-i))].
///
/// Source: Anderson & Darling, J. Am. Stat. Assoc. 49, 765 (1954), doi:10.1080/01621459.1954.10501232.
double anderson_darling(std::vector<double> u);

/// How often samples drawn from the fit itself, fitted again, lie further from their fit than the samples do from
/// theirs: p = (1 + number of larger A^2) / (1 + n_replicates). Fitted parameters make A^2 smaller than tables say, the
/// replicates know by how much. Above 4000 samples every n-th speed is drawn: the distribution of A^2 has reached its
/// limit there.
AndersonDarling anderson_darling_test(const LawLikelihood& likelihood, const Maximum& maximum, std::size_t n_replicates,
                                      std::uint64_t seed);

}  // namespace bouncelab::fit
