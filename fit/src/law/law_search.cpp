// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_search.hpp"

#include <algorithm>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "law/law_data.hpp"
#include "law/start_values.hpp"

namespace bouncelab::fit {
namespace {

/// Of bounces that are lost: the ball hit something else, or an impact was missed.
constexpr double kLostShare = 0.01;

constexpr std::size_t kManySamples = 1000;  // enough to tell two exponentials from a rounded peak

/// Numbers of terms in log b(v) to choose from by BIC; the first decides about the normal part, and has to follow the
/// widths well: normal scatter of widths that go with speed, taken as one width, looks like exponentials.
std::vector<std::size_t> numbers_of_terms(const LawFitConfig& config, std::size_t n) {
  constexpr std::size_t kFew = 30;
  if (config.n_scatter_terms > 0) return {config.n_scatter_terms};
  if (n >= kVeryMany) return {3, 6};  // the widths' shape is resolved beyond a parabola
  if (n < kFew) return {1};
  return {3, 2, 1};
}

ScatterFamily scatter_family(LawMethod method, std::size_t n_terms, double v_ref_mps) {
  switch (method) {
    case LawMethod::asymmetric_laplace:
      return {ScatterKind::normal_laplace, n_terms, v_ref_mps, kLostShare};
    case LawMethod::least_absolute:
      return {ScatterKind::symmetric_laplace, n_terms, v_ref_mps};
    case LawMethod::least_squares:
      break;
  }
  return {ScatterKind::normal, n_terms, v_ref_mps};
}

/// The metric of a poor start may be poor: once more from where it led.
Maximum maximise_twice(const LawLikelihood& likelihood, const Eigen::VectorXd& start) {
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  const Maximum maximum = maximise(function, start, likelihood.information(start));
  return maximum.converged ? maximum : maximise(function, maximum.x, likelihood.information(maximum.x));
}

/// From a point that is not far from the maximum of very many samples.
Maximum maximise_from_near(const LawLikelihood& likelihood, const Eigen::VectorXd& near) {
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  const Maximum maximum = maximise_nearby(function, near, likelihood.information(near));
  return maximum.converged ? maximum : maximise_twice(likelihood, maximum.x);
}

/// Every n-th sample of so many that a search among these first saves passes over all; absent of fewer.
std::optional<LawData> some_of(const LawData& data) {
  constexpr std::size_t kSome = 10000;
  const std::size_t stride = data.size() / kSome;
  return stride < 4 ? std::nullopt : std::optional(thinned(data, stride));
}

}  // namespace

Eigen::VectorXd start_by_some(const LawData& data, const LawModel& model, const ScatterFamily& family) {
  const std::optional<LawData> some = some_of(data);
  return start_values(some ? *some : data, model, family);
}

Maximum maximise_from_some(const LawLikelihood& likelihood, const Eigen::VectorXd& start) {
  const std::optional<LawData> some = some_of(likelihood.data());
  if (!some) return maximise_twice(likelihood, start);
  const Maximum near = maximise_twice(LawLikelihood(*some, likelihood.model(), likelihood.scatter()), start);
  return near.converged ? maximise_from_near(likelihood, near.x) : maximise_twice(likelihood, start);
}

namespace {

/// At all samples where timing errors are widened by what is seen.
std::optional<FirstLook> look_for(LawMethod method, const LawData& data, const LawModel& model) {
  const std::optional<LawData> some = method == LawMethod::least_squares ? some_of(data) : std::nullopt;
  return first_look(some ? *some : data, model);
}

/// @param start  of the samples themselves: the timing errors are widened by it
/// @param near   where the search begins, if it is known better
Candidate fit_family(const LawData& data, const LawModel& model, const ScatterFamily& family,
                     const Eigen::VectorXd& start, const Eigen::VectorXd* near = nullptr) {
  Candidate candidate{family, data, {}};
  if (family.is_two_sided()) {
    const Eigen::Index below = model.n_parameters(), above = below + static_cast<Eigen::Index>(family.n_terms);
    candidate.family.log_size = 0.5 * (start[below] + start[above]);
  }
  const auto n = static_cast<double>(data.size());
  if (family.kind != ScatterKind::normal)
    widen(candidate.data, scatter_model_of(start, model.n_parameters(), family),
          std::sqrt(static_cast<double>(model.n_parameters()) / n));
  const LawLikelihood likelihood(candidate.data, model, candidate.family);
  candidate.maximum = near ? maximise_from_near(likelihood, *near) : maximise_from_some(likelihood, start);
  candidate.bic = static_cast<double>(likelihood.n_parameters()) * log(n) - 2.0 * candidate.maximum.loglik;
  return candidate;
}

bool is_better(const Candidate& a, const Candidate& b) {
  return (a.maximum.converged && !b.maximum.converged) || (a.maximum.converged == b.maximum.converged && a.bic < b.bic);
}

/// Whether the normal part is larger than the exponentials.
bool is_large_part(const Candidate& candidate) { return candidate.maximum.x[candidate.maximum.x.size() - 1] > 0.0; }

/// Whether some of very many samples already rule out a normal part as large as the exponentials: by more than six
/// standard errors, which all of them would not reverse.
bool surely_no_large_part(const LawData& data, const LawModel& model, const ScatterFamily& family,
                          const Eigen::VectorXd& start) {
  constexpr double kSixStandardErrors = 36.0;
  const std::optional<LawData> some = some_of(data);
  if (!some) return false;
  const LawLikelihood likelihood(*some, model, family);
  const Maximum best = maximise_twice(likelihood, start);
  const Eigen::Index n_others = start.size() - 1;
  if (!best.converged || best.x[n_others] > 0.0) return false;
  Eigen::VectorXd as_large = best.x;
  as_large[n_others] = 0.0;
  const LogLikelihood of_others = [&](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
    as_large.head(n_others) = x;
    const double value = likelihood(as_large, gradient);
    if (gradient) gradient->conservativeResize(n_others);
    return value;
  };
  const Eigen::MatrixXd information = likelihood.information(as_large).topLeftCorner(n_others, n_others);
  const Maximum there = maximise(of_others, best.x.head(n_others), information);
  return there.converged && 2.0 * (best.loglik - there.loglik) > kSixStandardErrors;
}

}  // namespace

std::optional<Candidate> best_candidate(const LawData& data, const LawModel& model, const LawFitConfig& config) {
  std::optional<Candidate> best;
  const std::optional<FirstLook> look = look_for(config.method, data, model);
  if (!look) return best;
  for (const std::size_t n_terms : numbers_of_terms(config, data.size())) {
    ScatterFamily family = scatter_family(config.method, n_terms, data.v_mps[data.size() / 2]);
    if (best) family.kind = best->family.kind;  // whatever the widths do
    Eigen::VectorXd start = start_values(*look, family);
    const bool undecided = !best && family.kind == ScatterKind::normal_laplace && data.size() >= kManySamples;
    if (undecided) {
      ScatterFamily exponentials = family;
      exponentials.kind = ScatterKind::asymmetric_laplace;
      best = fit_family(data, model, exponentials, start_values(*look, exponentials));
      if (best->maximum.converged) {
        start = with_normal_part(best->maximum.x, family, model.n_parameters());
        if (surely_no_large_part(data, model, family, start)) continue;
      }
    }
    Candidate candidate = fit_family(data, model, family, start);
    const bool rounds_the_peak = undecided && best && best->maximum.converged && !is_large_part(candidate);
    if (!best || (is_better(candidate, *best) && !rounds_the_peak)) best = std::move(candidate);
  }
  return best;
}

std::optional<Candidate> again_without_outliers(const LawData& data, const LawModel& model, const LawFitConfig& config,
                                                const Candidate& before) {
  if (data.size() < kVeryMany || !before.maximum.converged) return best_candidate(data, model, config);
  const std::optional<FirstLook> look = look_for(config.method, data, model);
  if (!look) return std::nullopt;
  return fit_family(data, model, before.family, start_values(*look, before.family), &before.maximum.x);
}

bool remove_outliers(const LawData& data, const LawModel& model, const Candidate& fit, std::vector<std::size_t>& rows,
                     std::vector<std::size_t>& outliers) {
  if (!(fit.family.lost_share > 0.0)) return false;
  const std::vector<double> p = LawLikelihood(data, model, fit.family).probabilities_of_lost(fit.maximum.x);
  std::vector<std::size_t> kept, lost;
  for (std::size_t k = 0; k < data.size(); ++k) (p[k] > 0.5 ? lost : kept).push_back(rows[k]);
  // a curve that so few follow is none: a search of few samples may end beside nearly all of them
  if (lost.empty() || kept.size() < std::max(kFewest, lost.size())) return false;
  rows = std::move(kept);
  outliers.insert(outliers.end(), lost.begin(), lost.end());
  return true;
}

}  // namespace bouncelab::fit
