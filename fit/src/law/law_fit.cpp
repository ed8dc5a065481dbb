// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/law_fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/columns.hpp"
#include "law/law_likelihood.hpp"
#include "law/law_result.hpp"
#include "law/maximise.hpp"
#include "law/ordered_samples.hpp"
#include "law/replicates.hpp"
#include "law/start_values.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kFewest = 3;  // below, a mean has no scatter that it could be judged by
constexpr double kSpeedRatioMin = 1.2;
constexpr double kResolution = 1e-8;  // of eps: far below any timing; samples without any scatter are fitted too

std::vector<std::size_t> by_speed(const RestitutionSamples& samples) {
  std::vector<std::pair<double, std::size_t>> places;
  places.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) places.emplace_back(samples[k].v_mps, k);
  std::sort(places.begin(), places.end());
  std::vector<std::size_t> order;
  order.reserve(samples.size());
  for (const auto& place : places) order.push_back(place.second);
  return order;
}

void check(const RestitutionSamples& samples) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps) || !(s.v_mps > 0.0))
      throw InvalidArgument("sample " + std::to_string(k) + ": speed " + std::to_string(s.v_mps) + " m/s, eps " +
                            std::to_string(s.eps) + ": must be finite, the speed positive; leave it out");
  }
}

/// @param order  indices of the samples that are fitted
LawData law_data(const RestitutionSamples& samples, const std::vector<std::size_t>& order) {
  std::vector<std::size_t> drop_of(samples.size(), samples.size());
  for (const std::size_t k : order) drop_of[k] = 0;
  DropNumbers drops;
  for (std::size_t k = 0; k < samples.size(); ++k)
    if (drop_of[k] == 0) drop_of[k] = drops.of(samples[k]);
  LawData data;
  for (std::vector<double>* column : {&data.v_mps, &data.eps, &data.tau}) column->reserve(order.size());
  data.drop.reserve(order.size());
  for (const std::size_t k : order) {
    const RestitutionSample& s = samples[k];
    data.v_mps.push_back(s.v_mps);
    data.eps.push_back(s.eps);
    data.tau.push_back(hypot(s.sigma_eps.value_or(0.0), kResolution));
    data.drop.push_back(drop_of[k]);
  }
  return data;
}

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

struct Candidate {
  ScatterFamily family;
  LawData data;  ///< with widened timing errors
  Maximum maximum;
  double bic = HUGE_VAL;
};

/// The metric of a poor start may be poor: once more from where it led.
Maximum maximise_twice(const LawLikelihood& likelihood, const Eigen::VectorXd& start) {
  const LogLikelihood function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  const Maximum maximum = maximise(function, start, likelihood.information(start));
  return maximum.converged ? maximum : maximise(function, maximum.x, likelihood.information(maximum.x));
}

/// Every n-th sample of so many that a search among these first saves passes over all; absent of fewer.
std::optional<LawData> some_of(const LawData& data) {
  constexpr std::size_t kSome = 10000;
  const std::size_t stride = data.size() / kSome;
  return stride < 4 ? std::nullopt : std::optional(thinned(data, stride));
}

/// Start values by some of very many samples, where nothing but the begin of the search depends on them.
Eigen::VectorXd start_by_some(const LawData& data, const LawModel& model, const ScatterFamily& family) {
  const std::optional<LawData> some = some_of(data);
  return start_values(some ? *some : data, model, family);
}

/// Of all samples where timing errors are widened by them.
Eigen::VectorXd start_of(const LawData& data, const LawModel& model, const ScatterFamily& family) {
  return family.kind == ScatterKind::normal ? start_by_some(data, model, family) : start_values(data, model, family);
}

/// The maximum of very many samples is sought from that of some of them, which is a few standard errors off: most steps
/// of a search from far off then cost a fraction of a pass.
Maximum maximise_from_some(const LawLikelihood& likelihood, const Eigen::VectorXd& start) {
  const std::optional<LawData> some = some_of(likelihood.data());
  if (!some) return maximise_twice(likelihood, start);
  const Maximum near = maximise_twice(LawLikelihood(*some, likelihood.model(), likelihood.scatter()), start);
  return maximise_twice(likelihood, near.converged ? near.x : start);
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
  candidate.maximum = near ? maximise_twice(likelihood, *near) : maximise_from_some(likelihood, start);
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

/// By BIC how the widths go with speed, and from 1000 samples on whether there is a normal part beside the
/// exponentials. Fewer may hide one, and without it the peak would be too sure of itself; of two pure exponentials it
/// takes the information on the kink. One smaller than the exponentials is left out too: a rough ball's density is a
/// little rounded, and where its exponentials join is nearer to eps(v) than the rounded peak (docs/physics.md). Never
/// whether the sides differ: a test that misses a difference would bias the peak by it.
std::optional<Candidate> best_candidate(const LawData& data, const LawModel& model, const LawFitConfig& config) {
  std::optional<Candidate> best;
  for (const std::size_t n_terms : numbers_of_terms(config, data.size())) {
    ScatterFamily family = scatter_family(config.method, n_terms, data.v_mps[data.size() / 2]);
    if (best) family.kind = best->family.kind;  // whatever the widths do
    Eigen::VectorXd start = start_of(data, model, family);
    if (start.size() == 0) return std::nullopt;
    const bool undecided = !best && family.kind == ScatterKind::normal_laplace && data.size() >= kManySamples;
    if (undecided) {
      ScatterFamily exponentials = family;
      exponentials.kind = ScatterKind::asymmetric_laplace;
      best = fit_family(data, model, exponentials, start_of(data, model, exponentials));
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

/// The same family once more when outliers were set aside; of very many samples from where the search ended before.
std::optional<Candidate> again_without_outliers(const LawData& data, const LawModel& model, const LawFitConfig& config,
                                                const Candidate& before) {
  if (data.size() < kVeryMany || !before.maximum.converged) return best_candidate(data, model, config);
  const Eigen::VectorXd start = start_of(data, model, before.family);
  if (start.size() == 0) return std::nullopt;
  return fit_family(data, model, before.family, start, &before.maximum.x);
}

/// Moves samples that are lost bounces rather than scatter from `rows` to `outliers`.
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

std::string reason_not_to_fit(const LawData& data, const LawFitConfig& config, FitStatus& status) {
  if (data.size() < kFewest) {
    status = FitStatus::too_few_samples;
    return std::to_string(data.size()) + (data.size() == 1 ? " sample: at least " : " samples: at least ") +
           std::to_string(kFewest) + " are needed";
  }
  const double lo = data.v_mps[data.size() / 20], hi = data.v_mps[data.size() - 1 - data.size() / 20];
  if (config.kind == LawKind::series && config.orders.size() > 1 && hi < kSpeedRatioMin * lo) {
    status = FitStatus::not_identifiable;
    return "all speeds lie between " + std::to_string(lo) + " and " + std::to_string(hi) +
           " m/s: ε(v) is known there only, the constants A are not identifiable";
  }
  return {};
}

/// The law that so few samples can say something of: as asked for from eight on, two terms of a series from five on, a
/// constant below.
LawFitConfig for_few(LawFitConfig config, std::size_t n, std::vector<std::string>& notes) {
  constexpr std::size_t kThreeTerms = 8, kTwoTerms = 5;
  if (n >= kThreeTerms || config.kind != LawKind::series) return config;
  if (n >= kTwoTerms) {
    if (config.orders.size() <= 2) return config;
    config.orders.resize(2);
    notes.push_back(std::to_string(n) + " samples: two terms of the law");
    return config;
  }
  config.kind = LawKind::constant;
  notes.push_back(std::to_string(n) + " samples: one eps for all speeds");
  return config;
}

std::vector<std::pair<LawKind, std::vector<int>>> laws_to_compare(const LawFitConfig& config) {
  std::vector<std::pair<LawKind, std::vector<int>>> laws{{config.kind, config.orders}};
  for (const auto& orders : std::vector<std::vector<int>>{{2, 4, 5}, {2, 4}, {2, 4, 5, 6}})
    if (config.kind != LawKind::series || orders != config.orders) laws.push_back({LawKind::series, orders});
  for (const LawKind kind : {LawKind::viscoelastic, LawKind::constant})
    if (kind != config.kind) laws.push_back({kind, {}});
  return laws;
}

/// Other laws on the samples as the main fit left them: without its outliers, timing errors widened as for it.
std::vector<LawComparison> comparison(const Candidate& main, const LawFitConfig& config) {
  std::vector<LawComparison> results;
  for (const auto& [kind, orders] : laws_to_compare(config)) {
    const LawModel model = make_law_model(kind, orders, main.data.v_mps);
    const LawLikelihood likelihood(main.data, model, main.family);
    Maximum maximum = main.maximum;
    if (!results.empty()) {
      const Eigen::VectorXd start = start_by_some(main.data, model, main.family);
      if (start.size() == 0) continue;
      maximum = maximise_from_some(likelihood, start);
      if (!maximum.converged) continue;
    }
    LawComparison c;
    for (const std::string& name : model.names()) c.name += (c.name.empty() ? "" : ", ") + name;
    c.n_parameters = static_cast<std::size_t>(likelihood.n_parameters());
    c.loglik = maximum.loglik;
    c.aic = 2.0 * static_cast<double>(c.n_parameters) - 2.0 * c.loglik;
    c.bic = log(static_cast<double>(main.data.size())) * static_cast<double>(c.n_parameters) - 2.0 * c.loglik;
    results.push_back(std::move(c));
  }
  double aic = HUGE_VAL, bic = HUGE_VAL;
  for (const LawComparison& c : results) aic = std::min(aic, c.aic), bic = std::min(bic, c.bic);
  for (LawComparison& c : results) c.delta_aic = c.aic - aic, c.delta_bic = c.bic - bic;
  return results;
}

void add_bootstrap(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum, const LawFitConfig& config) {
  const auto drawn = bootstrap_by_drop(likelihood, maximum, config.n_bootstrap, config.seed, config.replicates);
  if (drawn.size() < 2) {
    fit.notes.push_back("no bootstrap by drop: it needs 8 drops or more");
    return;
  }
  const LawModel& model = likelihood.model();
  const auto errors_of = [&](auto&& value) {
    std::vector<double> values;
    for (const Eigen::VectorXd& q : drawn) values.push_back(value(q));
    return bootstrap_errors(std::move(values));
  };
  for (std::size_t i = 0; i < fit.parameters.size(); ++i)
    fit.parameters[i].estimate.bootstrap =
        errors_of([&](const Eigen::VectorXd& q) { return model.reported(q)[static_cast<Eigen::Index>(i)]; });
  for (NodeEstimate& node : fit.nodes)
    node.eps.bootstrap =
        errors_of([&](const Eigen::VectorXd& q) { return model.eps(std::span(&node.v_mps, 1), q)[0]; });
}

}  // namespace

const char* to_string(LawKind kind) {
  switch (kind) {
    case LawKind::series:
      return "series";
    case LawKind::viscoelastic:
      return "viscoelastic";
    case LawKind::constant:
      return "constant";
  }
  return "unknown";
}

const char* to_string(LawMethod method) {
  switch (method) {
    case LawMethod::asymmetric_laplace:
      return "asymmetric_laplace";
    case LawMethod::least_squares:
      return "least_squares";
    case LawMethod::least_absolute:
      return "least_absolute";
  }
  return "unknown";
}

namespace {
double scale_at(const std::vector<double>& c, double x) {
  double sum = 0.0;
  for (std::size_t k = c.size(); k-- > 0;) sum = sum * x + c[k];
  return exp(sum);
}

LawFit fitted_law(const RestitutionSamples& samples, const OrderedSamples& ordered, const LawFitConfig& asked) {
  LawFit fit;
  if (asked.n_scatter_terms > 8)
    throw InvalidArgument("terms of the scatter " + std::to_string(asked.n_scatter_terms) + ": 1 to 8, 0 = by BIC");
  std::vector<std::size_t> rows = ordered.rows;
  LawData data = ordered.data;
  fit.n = data.size();
  const LawFitConfig config = for_few(asked, fit.n, fit.notes);
  fit.kind = config.kind;
  fit.method = config.method;
  fit.message = reason_not_to_fit(data, config, fit.status);
  if (!fit.message.empty()) return fit;

  const LawModel model = make_law_model(config.kind, config.orders, data.v_mps);
  data.basis = make_law_basis(model, data.v_mps);
  auto candidate = best_candidate(data, model, config);
  // outliers widen the scatter they are judged by: again until none is left
  while (candidate && data.size() > kFewest && remove_outliers(data, model, *candidate, rows, fit.outliers)) {
    data = law_data(samples, rows);
    data.basis = make_law_basis(model, data.v_mps);
    candidate = again_without_outliers(data, model, config, *candidate);
  }
  std::sort(fit.outliers.begin(), fit.outliers.end());
  fit.n = data.size();
  if (!candidate) {
    fit.status = FitStatus::not_applicable;
    fit.message = "the median ε is not between 0.05 and 1: no viscoelastic sphere does that";
    return fit;
  }
  const LawLikelihood likelihood(candidate->data, model, candidate->family);
  describe_fit(fit, likelihood, candidate->maximum,
               config.node_speeds_mps.empty() ? spread_speeds(data.v_mps, 3) : config.node_speeds_mps,
               config.intervals);
  if (!candidate->maximum.converged) return fit;
  if (config.n_goodness > 0)
    fit.anderson_darling = anderson_darling_test(likelihood, candidate->maximum, config.n_goodness, config.seed);
  if (config.n_bootstrap > 0) add_bootstrap(fit, likelihood, candidate->maximum, config);
  if (config.compare_laws) fit.comparison = comparison(*candidate, config);
  return fit;
}

}  // namespace

double ScatterModel::below(double v_mps) const { return scale_at(log_below, log(v_mps / v_ref_mps)); }
double ScatterModel::above(double v_mps) const { return scale_at(log_above, log(v_mps / v_ref_mps)); }
double ScatterModel::normal(double v_mps) const { return normal_ratio * std::sqrt(below(v_mps) * above(v_mps)); }
double ScatterModel::mean_minus_peak(double v_mps) const {
  const double b = below(v_mps), a = above(v_mps);
  const double offset = normal_ratio > 0.0 ? std::sqrt(a * b) * mode_offset(log(a / b), log(normal_ratio)).value : 0.0;
  return a - b - offset;
}

OrderedSamples ordered_by_speed(const RestitutionSamples& samples) {
  check(samples);
  OrderedSamples ordered{by_speed(samples), {}};
  ordered.data = law_data(samples, ordered.rows);
  return ordered;
}

LawFit fit_law(const RestitutionSamples& samples, const OrderedSamples& ordered, const LawFitConfig& config) {
  LawFit fit;
  // once for the whole search, not for each of its likelihoods
  with_threads(0, [&] { fit = fitted_law(samples, ordered, config); });
  return fit;
}

LawFit fit_law(const RestitutionSamples& samples, const LawFitConfig& config) {
  return fit_law(samples, ordered_by_speed(samples), config);
}

}  // namespace bouncelab::fit
