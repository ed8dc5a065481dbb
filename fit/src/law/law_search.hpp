// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_likelihood.hpp"
#include "numerics/maximise.hpp"

namespace bouncelab::fit {

inline constexpr std::size_t kFewest = 3;  // below, a mean has no scatter that it could be judged by

/// A family of scatter and where its likelihood has its maximum.
struct Candidate {
  ScatterFamily family;
  LawData data;  ///< with widened timing errors
  Maximum maximum;
  double bic = HUGE_VAL;
};

/// Start values by some of very many samples, where nothing but the begin of the search depends on them.
Eigen::VectorXd start_by_some(const LawData& data, const LawModel& model, const ScatterFamily& family);

/// The maximum of very many samples is sought from that of some of them, which is a few standard errors off: most steps
/// of a search from far off then cost a fraction of a pass.
Maximum maximise_from_some(const LawLikelihood& likelihood, const Eigen::VectorXd& start);

/// By BIC how the widths go with speed, and from 1000 samples on whether there is a normal part beside the
/// exponentials. Fewer may hide one, and without it the peak would be too sure of itself; of two pure exponentials it
/// takes the information on the kink. One smaller than the exponentials is left out too: a rough ball's density is a
/// little rounded, and where its exponentials join is nearer to eps(v) than the rounded peak (docs/physics.md). Never
/// whether the sides differ: a test that misses a difference would bias the peak by it.
std::optional<Candidate> best_candidate(const LawData& data, const LawModel& model, const LawFitConfig& config);

/// The same family once more when outliers were set aside; of very many samples from where the search ended before.
std::optional<Candidate> again_without_outliers(const LawData& data, const LawModel& model, const LawFitConfig& config,
                                                const Candidate& before);

/// Moves samples that are lost bounces rather than scatter from `rows` to `outliers`.
bool remove_outliers(const LawData& data, const LawModel& model, const Candidate& fit, std::vector<std::size_t>& rows,
                     std::vector<std::size_t>& outliers);

}  // namespace bouncelab::fit
