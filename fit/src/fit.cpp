// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/fit.hpp"

#include <cmath>

#include "averaged/averaged_curve.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/fit/usable_samples.hpp"
#include "law/law_model.hpp"
#include "law/law_search.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {
namespace {

LawFitConfig alternative(const LawFitConfig& main, LawKind kind, LawMethod method, const LawFit& fitted) {
  LawFitConfig config = main;
  config.kind = kind;
  config.method = method;
  config.n_goodness = config.n_bootstrap = 0;
  config.compare_laws = false;
  // shown for comparison only
  if (method != main.method) config.intervals = IntervalMethod::covariance;
  for (const NodeEstimate& node : fitted.nodes)
    if (main.node_speeds_mps.empty()) config.node_speeds_mps.push_back(node.v_mps);
  return config;
}

MemoryFitConfig with_memory(const FitConfig& config, const LawFit& main) {
  MemoryFitConfig memory;
  memory.kind = config.law.kind;
  memory.orders = config.law.orders;
  memory.seed = config.law.seed;
  memory.n_goodness = config.n_goodness;
  for (const NodeEstimate& node : main.nodes) memory.node_speeds_mps.push_back(node.v_mps);
  return memory;
}

/// Only where they are is it known that intervals of the fit with memory cover (bouncelab calibrate --memory).
bool drops_are_long(const RestitutionSamples& samples) {
  constexpr std::size_t kFewestDrops = 5, kFewestImpactsADrop = 30;
  std::size_t n_drops = samples.empty() ? 0 : 1;
  for (std::size_t k = 1; k < samples.size(); ++k)
    n_drops += samples[k].drop != samples[k - 1].drop || samples[k].recording != samples[k - 1].recording;
  return n_drops >= kFewestDrops && samples.size() >= kFewestImpactsADrop * n_drops;
}

/// Adds an independent error to an estimate.
void widen(Estimate& e, double se) {
  if (!(se > 0.0)) return;
  constexpr double k95 = 1.959963984540054;
  const auto wider = [&](std::optional<Interval>& interval, double reach) {
    if (!interval) return;
    interval->lo = e.value - hypot(e.value - interval->lo, reach * se);
    interval->hi = e.value + hypot(interval->hi - e.value, reach * se);
  };
  wider(e.ci68, 1.0);
  wider(e.ci95, k95);
  if (e.se) *e.se = hypot(*e.se, se);
  if (e.se_independent) *e.se_independent = hypot(*e.se_independent, se);
}

/// What drag and contact time leave open of a law: by fits with each a standard deviation to either side.
class OpenByDragAndContact {
 public:
  OpenByDragAndContact(const RestitutionSamples& raw, const AirAndContact& known, const DeviationEstimate& estimate,
                       LawFitConfig config) {
    config.intervals = IntervalMethod::covariance;
    config.n_goodness = config.n_bootstrap = 0;
    config.compare_laws = false;
    const auto add = [&](Deviation sd) {
      const auto& m = estimate.mean;
      const auto moved = [&](double side) {
        return fit_law(at_the_plate(raw, known, {m.ln_kappa + side * sd.ln_kappa, m.ln_tau + side * sd.ln_tau}),
                       config);
      };
      sides_.push_back({moved(-1.0), moved(1.0)});
    };
    if (known.has_drag) add({estimate.sd.ln_kappa, 0.0});
    if (known.has_contact) add({0.0, estimate.sd.ln_tau});
  }
  /// A LawFit or a MemoryFit of the same form of law.
  template <class Fit>
  void widen_law(Fit& law) const {
    for (NodeEstimate& node : law.nodes)
      widen(node.eps, open([&](const LawFit& f) { return f.law ? restitution(*f.law, node.v_mps) : NAN; }));
    const auto parameter = [](std::size_t k) {
      return [k](const LawFit& f) { return k < f.parameters.size() ? f.parameters[k].estimate.value : NAN; };
    };
    for (std::size_t k = 0; k < law.parameters.size(); ++k) widen(law.parameters[k].estimate, open(parameter(k)));
    Matrix& covariance = law.covariance;
    for (std::size_t i = 0; i < covariance.size(); ++i)
      for (std::size_t j = 0; j < covariance.size(); ++j) covariance[i][j] += shared(parameter(i), parameter(j));
    for (std::size_t i = 0; i < covariance.size(); ++i)
      for (std::size_t j = 0; j < covariance.size(); ++j)
        law.correlation[i][j] = i == j ? 1.0 : covariance[i][j] / std::sqrt(covariance[i][i] * covariance[j][j]);
    for (CurvePoint& point : law.curve) {
      Estimate e;
      e.value = point.y;
      e.se = point.se;
      e.ci95 = point.band95;
      widen(e, open([&](const LawFit& f) { return f.law ? restitution(*f.law, point.x) : NAN; }));
      point.se = e.se;
      point.band95 = e.ci95;
    }
  }

 private:
  template <class Of>
  double open(Of of) const {
    return std::sqrt(shared(of, of));
  }
  /// Of the covariance of two quantities.
  template <class Of, class Other>
  double shared(Of of, Other other) const {
    double sum = 0.0;
    for (const auto& [below, above] : sides_) {
      const double product = 0.25 * (of(above) - of(below)) * (other(above) - other(below));
      if (std::isfinite(product)) sum += product;
    }
    return sum;
  }
  std::vector<std::pair<LawFit, LawFit>> sides_;
};

FitResult fit_on_these_threads(const RestitutionSamples& samples, const FitConfig& config,
                               const ProgressCallback& progress) {
  const double n_steps = config.memory == UseMemory::never ? 6.0 : 7.0;
  double n_done = 0.0;
  const auto step = [&] {
    if (progress) progress(n_done, n_steps);
    n_done += 1.0;
  };
  FitResult result;
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  AirAndContact known = air_and_contact_of(*part);
  LawFitConfig main = config.law;
  DeviationEstimate deviation;
  if (known.is_open() || part->size() < kVeryMany) {
    LawFitConfig first = main;
    first.intervals = IntervalMethod::covariance;
    const LawFit at_first = fit_law(at_the_plate(*part, known, {}), first);
    for (const NodeEstimate& node : at_first.nodes)
      if (config.law.node_speeds_mps.empty()) main.node_speeds_mps.push_back(node.v_mps);
    result.averaged =
        averaged_curve(*PartOfSamples(*part, at_first.outliers), known, config.law, main.node_speeds_mps, deviation);
    if (deviation.is_ideal) known = worlds_of(known).back();
  }
  const RestitutionSamples moved = known.is_open() ? at_the_plate(*part, known, deviation.mean) : RestitutionSamples{};
  const RestitutionSamples& used = known.is_open() ? moved : *part;
  step();
  main.n_goodness = config.n_goodness;
  main.compare_laws = true;
  const OrderedSamples ordered = ordered_by_speed(used);
  result.law = fit_law(used, ordered, main);
  step();
  if (config.memory != UseMemory::never) {
    // the impacts as they followed each other, outliers among them: where one is missing a chain ends
    if (config.memory == UseMemory::always || drops_are_long(used))
      result.memory = fit_memory(used, result.law, with_memory(config, result.law));
    step();
  }
  // what the law cannot explain would widen every other fit
  const PartOfSamples without_outliers(used, result.law.outliers);
  const RestitutionSamples& kept = *without_outliers;
  const OrderedSamples ordered_kept = result.law.outliers.empty() ? ordered : ordered_by_speed(kept);
  const auto other = [&](LawKind kind, LawMethod method) {
    return fit_law(kept, ordered_kept, alternative(config.law, kind, method, result.law));
  };
  result.law_least_squares = other(config.law.kind, LawMethod::least_squares);
  step();
  result.law_least_absolute = other(config.law.kind, LawMethod::least_absolute);
  step();
  result.law_viscoelastic = other(LawKind::viscoelastic, config.law.method);
  step();
  result.histograms = fit_histograms(kept, config.histograms, result.law);
  result.density = density_picture(used);
  BudgetConfig budget = budget_config_of(*part, config.budget);
  if (known.has_drag && budget.drag == Effect::present) budget.drag = Effect::corrected;
  if (known.has_contact && budget.contact_time == Effect::present) budget.contact_time = Effect::corrected;
  result.budget = error_budget(kept, quoted_law(result), budget);
  step();
  // with the outliers of the pooled law: they may be all of one recording
  if (config.compare_recordings) result.recordings = compare_recordings(used, config.law, result.law);
  result.kinds_of_drops = two_kinds_of_drops(used);
  const bool recordings_agree =
      result.recordings.rows.empty() || (result.recordings.test && !disagree(result.recordings));
  result.is_one_ball = config.pool || (recordings_agree && !result.kinds_of_drops);
  step();
  if (known.is_open()) {
    const PartOfSamples raw(*part, result.law.outliers);
    LawFitConfig same = main;
    same.node_speeds_mps.clear();
    for (const NodeEstimate& node : result.law.nodes) same.node_speeds_mps.push_back(node.v_mps);
    const OpenByDragAndContact open(*raw, known, deviation, same);
    open.widen_law(result.law);
    if (result.memory) open.widen_law(*result.memory);
  }
  const LawFit quoted = quoted_law(result);
  if (result.is_one_ball && !result.law.nodes.empty()) {
    const double v_mps = config.dem_speed_mps.value_or(result.law.nodes[result.law.nodes.size() / 2].v_mps);
    LawFit shown = quoted;
    shown.curve = quoted_curve(result);
    if (!memory_holds(result) && result.averaged && !shown.curve.empty()) {
      TableLaw table;
      for (const CurvePoint& p : shown.curve) {
        table.v_mps.push_back(p.x);
        table.eps.push_back(p.y);
      }
      shown.law = std::move(table);
    }
    const SampleConditions& conditions = used.front().conditions;
    result.dem_export =
        dem_export(shown, v_mps, conditions.ball, conditions.plate, memory_holds(result) ? &*result.memory : nullptr);
  }
  result.status = quoted.status;
  result.n_used = result.law.n;
  result.n_left_out = left_out.n;
  if (!result.law.outliers.empty()) result.n_left_out["outlier"] = result.law.outliers.size();
  return result;
}

}  // namespace

FitResult fit_all(const RestitutionSamples& samples, const FitConfig& config, const ProgressCallback& progress) {
  FitResult result;
  with_threads(config.n_threads, [&] { result = fit_on_these_threads(samples, config, progress); });
  return result;
}

bool memory_holds(const FitResult& result) {
  return result.memory && result.memory->holds && !result.memory->nodes.empty();
}

LawFit quoted_law(const FitResult& result) {
  LawFit law = result.law;
  if (!memory_holds(result)) return law;
  const MemoryFit& memory = *result.memory;
  law.parameters = memory.parameters;
  law.covariance = memory.covariance;
  law.correlation = memory.correlation;
  law.nodes = memory.nodes;
  law.node_correlation = memory.node_correlation;
  law.curve = memory.curve;
  law.law = memory.law;
  law.message = not_identified_in_words(memory.parameters, memory.n);
  law.status = law.message.empty() ? FitStatus::ok : FitStatus::not_identifiable;
  return law;
}

const std::vector<NodeEstimate>& quoted_nodes(const FitResult& result) {
  if (memory_holds(result)) return result.memory->nodes;
  return result.averaged ? result.averaged->nodes : result.law.nodes;
}

const std::vector<CurvePoint>& quoted_curve(const FitResult& result) {
  static const std::vector<CurvePoint> none;
  if (!result.is_one_ball) return none;
  if (memory_holds(result)) return result.memory->curve;
  return result.averaged && !result.averaged->curve.empty() ? result.averaged->curve : result.law.curve;
}

bool usable(const FitResult& result) {
  return (result.status == FitStatus::ok || result.status == FitStatus::not_identifiable) && !result.law.nodes.empty();
}

}  // namespace bouncelab::fit
