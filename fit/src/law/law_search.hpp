// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/numerics.hpp"

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

inline constexpr std::size_t kFewest = 3;  // below, a mean has no scatter that it could be judged by

/// A family of scatter and where its likelihood has its maximum.
struct Candidate {
  ScatterFamily family;
  LawData data;  ///< with widened timing errors
  Maximum maximum;
  double bic = HUGE_VAL;
};

/// Converged before not, then by BIC.
bool is_better(const Candidate& a, const Candidate& b);

/// By BIC how the widths go with speed, whether they go with the place of an impact in its drop, as those of a rough
/// ball released at rest do (its first impacts only lose, and a function of speed alone takes that for a lower eps),
/// and from 1000 samples on whether there is a normal part beside the exponentials. Fewer may hide one, and without it
/// the peak would be too sure of itself; of two pure exponentials it takes the information on the kink. One smaller
/// than the exponentials is left out too: a rough ball's density is a little rounded, and where its exponentials join
/// is nearer to eps(v) than the rounded peak (docs/physics.md). Never whether the sides differ: a test that misses a
/// difference would bias the peak by it.
std::optional<Candidate> best_candidate(const LawData& data, const LawModel& model, const LawFitConfig& config);

/// The same family when outliers were set aside, from where its search ended before.
std::optional<Candidate> again_without_outliers(const LawData& data, const LawModel& model, const Candidate& before);

/// Moves samples that are lost bounces rather than scatter from `rows` to `outliers`.
bool remove_outliers(const LawData& data, const LawModel& model, const Candidate& fit, std::vector<std::size_t>& rows,
                     std::vector<std::size_t>& outliers);

/// Says which constants the data determine: known to a third of themselves, or their term C_i A_i v^(i/10) at `v_mps`
/// to within the loss 1 - `eps` there, and not tied to one that is neither by a correlation above .99.
void mark_identified(std::vector<NamedEstimate>& parameters, const LawModel& model, const Eigen::MatrixXd& correlation,
                     double v_mps, double eps);

/// Which constants `n` impacts do not determine, with their intervals; absent where they determine all.
std::optional<Note> not_identified(const std::vector<NamedEstimate>& parameters, std::size_t n);

/// Turns the maximum of the likelihood into what LawFit reports: parameters with errors, nodes, curve, goodness,
/// status.
void describe_fit(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum,
                  const std::vector<double>& node_speeds_mps, IntervalMethod intervals);

}  // namespace bouncelab::fit
