// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/unexplained_jitter.hpp"

#include <algorithm>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"

namespace bouncelab::detection {
namespace {

std::vector<std::vector<float>> residuals_of(TemplateEstimation& e) {
  std::vector<std::vector<float>> residuals;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    residuals.push_back(residual_of(e, impact));
    for (float& x : residuals.back()) x /= static_cast<float>(impact.estimate.amplitude);
  }
  return residuals;
}

}  // namespace

double degrees_of_freedom(const std::vector<std::vector<float>>& residuals) {
  constexpr double kFewest = 2.0;  // in phase and in quadrature
  if (residuals.size() < 2) return kFewest;
  double trace = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    trace += audio::dot(residuals[k], residuals[k]);
    for (std::size_t j = 0; j < k; ++j) squares += 2.0 * square(audio::dot(residuals[j], residuals[k]));
  }
  const auto n = static_cast<double>(residuals.size());
  trace /= n;
  squares /= n * (n - 1.0);
  const auto most = static_cast<double>(residuals.front().size());
  return squares > 0.0 ? std::clamp(trace * trace / squares, kFewest, most) : most;
}

void add_unexplained_jitter(TemplateEstimation& e, double quiet) {
  std::vector<double> unexplained;  // over what the template explains
  for (const TrainingImpact& impact : e.training) {
    const double explained = 2.0 * impact.estimate.log_likelihood_ratio;
    if (impact.is_averaged()) unexplained.push_back(std::max(0.0, impact.total - explained - quiet) / explained);
  }
  if (unexplained.empty()) return;
  const double dof = degrees_of_freedom(residuals_of(e));
  const double phase2 = upper_median(std::move(unexplained)) / dof;
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  for (std::size_t j = 0; j < subbands.n(); ++j)
    subbands.jitter2[j] =
        std::max(subbands.jitter2[j], phase2 * filter.energy(subbands.edge[j], subbands.edge[j + 1]) /
                                          (filter.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30));
}

}  // namespace bouncelab::detection
