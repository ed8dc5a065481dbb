// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_likelihood.hpp"
#include "law/maximise.hpp"

namespace bouncelab::fit {

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

/// The law's coordinates q from drops drawn with replacement, as many as there are: what one would find in repetitions
/// of the experiment, whatever goes on within a drop. Replicates whose search fails are left out. Empty for fewer than
/// 8 drops.
/// @param source  absent: all are made here
std::vector<Eigen::VectorXd> bootstrap_by_drop(const LawLikelihood& likelihood, const Maximum& maximum,
                                               std::size_t n_replicates, std::uint64_t seed);

/// Standard deviation and percentile intervals. @param values  at least 2
BootstrapErrors bootstrap_errors(std::vector<double> values);

}  // namespace bouncelab::fit
