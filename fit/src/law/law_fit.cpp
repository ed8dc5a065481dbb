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
#include "bouncelab/fit/fit.hpp"
#include "law/goodness.hpp"
#include "law/law_likelihood.hpp"
#include "law/law_model.hpp"
#include "law/law_search.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kTwoTerms = 5, kThreeTerms = 8;  // samples

/// The law that samples can say something of: as asked for from eight on, two terms of a series from five on, a
/// constant below, and where all have about one speed.
LawFitConfig for_these(LawFitConfig config, const LawData& data, std::vector<Note>& notes) {
  const std::size_t n = data.size();
  if (n == 0) return config;
  const double lo = data.v_mps[n / 20], hi = data.v_mps[n - 1 - n / 20];
  if (config.kind == LawKind::series && config.orders.size() > 1 && hi < kOneSpeed * lo) {
    config.kind = LawKind::constant;
    notes.push_back({NoteKind::one_speed, {lo, hi}});
    return config;
  }
  if (n >= kThreeTerms || config.kind != LawKind::series) return config;
  if (n >= kTwoTerms) {
    if (config.orders.size() <= 2) return config;
    config.orders.resize(2);
    notes.push_back({NoteKind::two_terms, {static_cast<double>(n)}});
    return config;
  }
  config.kind = LawKind::constant;
  notes.push_back({NoteKind::one_constant, {static_cast<double>(n)}});
  return config;
}

/// A law of samples, and the likeliest scatter about it.
struct LawAndScatter {
  LawKind kind;
  LawModel model;
  std::optional<Candidate> candidate;
};

/// As configured. Where speeds count as one, two terms of the series that was asked for if the samples show how eps
/// falls among them: many precise ones do.
LawAndScatter law_and_scatter(const LawData& data, const LawFitConfig& config, LawFitConfig asked) {
  const auto fitted = [&](const LawFitConfig& law) {
    LawModel model = make_law_model(law.kind, law.orders, data.v_mps);
    auto candidate = best_candidate(data, model, law);
    return LawAndScatter{law.kind, std::move(model), std::move(candidate)};
  };
  LawAndScatter likeliest = fitted(config);
  constexpr double kLeastRatio = 1.01;
  if (config.kind != LawKind::constant || asked.kind != LawKind::series || asked.orders.size() < 2 ||
      data.size() < kThreeTerms || !(data.v_mps.back() > kLeastRatio * data.v_mps.front()))
    return likeliest;
  asked.orders.resize(2);
  LawAndScatter series = fitted(asked);
  if (series.candidate && likeliest.candidate && is_better(*series.candidate, *likeliest.candidate)) return series;
  return likeliest;
}

}  // namespace

const char* to_string(LawKind kind) {
  constexpr const char* kWords[]{"series", "viscoelastic", "constant"};
  return kWords[static_cast<std::size_t>(kind)];
}

namespace {

LawFit fitted_law(const RestitutionSamples& samples, const LawFitConfig& asked) {
  LawFit fit;
  std::vector<std::size_t> rows = by_speed(samples);
  LawData data = law_data(samples, rows);
  fit.n = data.size();
  const LawFitConfig config = for_these(asked, data, fit.notes);
  fit.kind = config.kind;
  if (data.size() < kFewest) {
    fit.why = Note{NoteKind::too_few_samples, {static_cast<double>(data.size()), static_cast<double>(kFewest)}};
    return fit;
  }

  LawAndScatter found = law_and_scatter(data, config, asked);
  if (found.kind != config.kind) fit.notes.clear();
  fit.kind = found.kind;
  const LawModel& model = found.model;
  std::optional<Candidate>& candidate = found.candidate;
  // outliers widen the scatter they are judged by: again until none is left
  while (candidate && data.size() > kFewest && remove_outliers(data, model, *candidate, rows, fit.outliers)) {
    data = law_data(samples, rows);
    candidate = again_without_outliers(data, model, *candidate);
  }
  std::sort(fit.outliers.begin(), fit.outliers.end());
  fit.n = data.size();
  if (!candidate) {
    fit.status = FitStatus::not_applicable;
    fit.why = Note{NoteKind::not_a_sphere};
    return fit;
  }
  const LawLikelihood likelihood(candidate->data, model, candidate->family);
  describe_fit(fit, likelihood, candidate->maximum,
               config.node_speeds_mps.empty() ? node_speeds(data.v_mps) : config.node_speeds_mps, config.intervals);
  if (!candidate->maximum.converged) return fit;
  constexpr std::size_t kFewestOfGoodness = 100;  // of fewer the test sees no scatter but one that is grossly another
  if (config.n_goodness > 0 && fit.n >= kFewestOfGoodness)
    fit.anderson_darling = anderson_darling_test(likelihood, candidate->maximum, config.n_goodness, config.seed);
  return fit;
}

}  // namespace

double ScatterModel::below(double v_mps) const { return exp(polynomial(log_below, log(v_mps / v_ref_mps))); }
double ScatterModel::above(double v_mps) const { return exp(polynomial(log_above, log(v_mps / v_ref_mps))); }
double ScatterModel::normal(double v_mps) const { return normal_ratio * std::sqrt(below(v_mps) * above(v_mps)); }
double ScatterModel::mean_distance(double v_mps) const {
  const double b = below(v_mps), a = above(v_mps);
  return (b * b + a * a) / (b + a);
}
double ScatterModel::mean_minus_peak(double v_mps) const {
  const double b = below(v_mps), a = above(v_mps);
  const double offset = normal_ratio > 0.0 ? std::sqrt(a * b) * mode_offset(log(a / b), log(normal_ratio)).value : 0.0;
  return a - b - offset;
}
double ScatterModel::variance(double v_mps) const {
  return square(below(v_mps)) + square(above(v_mps)) + square(normal(v_mps));
}

LawFit fit_law(const RestitutionSamples& samples, const LawFitConfig& config) {
  constexpr std::size_t kMostScatterTerms = 10;
  FitConfig described;
  described.law = config;
  described.law.node_speeds_mps.clear();  // those of fit_all go with the samples
  check_options(described);
  for (const double v_mps : config.node_speeds_mps)
    if (!(v_mps > 0.0 && std::isfinite(v_mps)))
      throw InvalidArgument("nodes: " + short_number(v_mps) + " m/s must be finite and above 0");
  if (config.n_scatter_terms > kMostScatterTerms)
    throw InvalidArgument("n_scatter_terms: " + std::to_string(config.n_scatter_terms) + " must be from 0 to " +
                          std::to_string(kMostScatterTerms));
  LawFit fit;
  // once for the whole search, not for each of its likelihoods
  with_threads(0, [&] { fit = fitted_law(samples, config); });
  return fit;
}

}  // namespace bouncelab::fit
