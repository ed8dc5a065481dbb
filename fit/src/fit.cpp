// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/core/numerics.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "curve/smooth_curve.hpp"
#include "law/law_model.hpp"
#include "law/law_search.hpp"
#include "numerics/numerics.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {
namespace {

/// The law of one constant.
LawFitConfig viscoelastic(LawFitConfig config) {
  config.kind = LawKind::viscoelastic;
  return config;
}

MemoryFitConfig with_memory(const FitConfig& config) {
  MemoryFitConfig memory;
  memory.kind = config.law.kind;
  memory.orders = config.law.orders;
  memory.seed = config.law.seed;
  memory.n_goodness = config.n_goodness;
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
  const auto wider = [&](std::optional<Interval>& interval, double reach) {
    if (!interval) return;
    interval->lo = e.value - hypot(e.value - interval->lo, reach * se);
    interval->hi = e.value + hypot(interval->hi - e.value, reach * se);
  };
  wider(e.ci68, 1.0);
  wider(e.ci95, kNormal95);
  if (e.se) *e.se = hypot(*e.se, se);
  if (e.se_independent) *e.se_independent = hypot(*e.se_independent, se);
}

/// Adds to a law what drag and contact time leave open. @param covariance  by that, of the law's values q
/// @param law  a LawFit or a MemoryFit of the same form of law
template <class Fit>
void widen_law(Fit& law, const LawModel& model, const Eigen::VectorXd& q, const Eigen::MatrixXd& covariance) {
  const auto variance_at = [&](double v_mps) {
    const Eigen::VectorXd row = model.jacobian(std::vector{v_mps}, q).row(0).transpose();
    return congruence(row, covariance)(0, 0);
  };
  for (NodeEstimate& node : law.nodes) widen(node.eps, std::sqrt(variance_at(node.v_mps)));
  const Eigen::MatrixXd of_parameters = congruence(model.reported_jacobian(q).transpose(), covariance);
  for (std::size_t i = 0; i < law.covariance.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    widen(law.parameters[i].estimate, std::sqrt(of_parameters(row, row)));
    for (std::size_t j = 0; j < law.covariance.size(); ++j)
      law.covariance[i][j] += of_parameters(row, static_cast<Eigen::Index>(j));
  }
}

/// Whether the law describes the samples, and what drag and contact time leave open of it.
void look_beside(const SmoothCurve& curve, LawFit& law, const LawFitConfig& config, MemoryFit* memory,
                 const RestitutionSamples& samples) {
  if (!law.law || law.parameters.empty()) return;
  const LawModel model = make_law_model(law.kind, config.orders, speeds_of(samples));
  const Eigen::VectorXd q = model.values_of(*law.law);
  const LawBeside beside = curve.beside(model, q, law.scatter);
  law.misfit = beside.misfit;
  widen_law(law, model, q, beside.covariance);
  if (memory) widen_law(*memory, model, q, beside.covariance);
}

/// What is stated as the law's constants: none of samples that are of no one ball.
Constants constants_of(const FitResult& result, const LawFit& viscoelastic) {
  const LawFit& law = result.law;
  if (!result.is_one_ball) return {FitStatus::not_applicable, {}, false, {}, {}, {}};
  Constants constants{law.status, law.why, false, law.parameters, law.covariance, {}};
  if (memory_holds(result)) {
    const MemoryFit& memory = *result.memory;
    constants.with_memory = true;
    constants.parameters = memory.parameters;
    constants.covariance = memory.covariance;
    constants.why = not_identified(memory.parameters, memory.n);
    constants.status = constants.why ? FitStatus::not_identifiable : FitStatus::ok;
  }
  if (viscoelastic.misfit && viscoelastic.misfit->ln_bayes_factor <= kStrongBayesFactor)
    constants.gamma = viscoelastic.parameters.front().estimate;
  if (law.misfit && law.misfit->ln_bayes_factor > kStrongBayesFactor) {
    constants.status = FitStatus::not_applicable;
    constants.why = Note{NoteKind::law_contradicted, {law.misfit->v_mps, law.misfit->off, law.misfit->ln_bayes_factor}};
    constants.parameters.clear();
    constants.covariance.clear();
  }
  return constants;
}

/// The curve's mean less what the density of the scatter has between mean and peak.
void add_peaks(Curve& curve, const LawFit& law) {
  if (!law.scatter) return;
  for (CurveNode& node : curve.nodes) {
    Estimate& peak = node.peak.emplace(node.mean);
    const double shift = -law.scatter->mean_minus_peak(node.v_mps);
    peak.value += shift;
    for (std::optional<Interval>* interval : {&peak.ci68, &peak.ci95})
      if (*interval) (*interval)->lo += shift, (*interval)->hi += shift;
    // each side is known as the mean of half of the samples
    const double below = law.scatter->below(node.v_mps), above = law.scatter->above(node.v_mps);
    widen(peak, hypot(below, above) / std::sqrt(0.5 * static_cast<double>(law.n)));
  }
}

/// With standard errors so many times as large.
RestitutionSamples with_errors(RestitutionSamples samples, double factor) {
  for (RestitutionSample& s : samples)
    for (std::optional<double>* sigma : {&s.sigma_v_mps, &s.sigma_eps})
      if (*sigma) **sigma *= factor;
  return samples;
}

/// What the curve is fitted to, and what all other fits are.
struct Prepared {
  Prepared(const RestitutionSamples& samples, const FitConfig& config);
  /// At the plate, with the errors that the curve finds.
  const RestitutionSamples& used() const { return at_plate ? *at_plate : *part; }
  /// As the intervals give them where nobody knows what the air did to them.
  const RestitutionSamples& shown() const { return curve && curve->known().is_named ? used() : *part; }

  LeftOut left_out;
  PartOfSamples part;                          ///< usable, as measured
  std::optional<SmoothCurve> curve;            ///< absent without samples
  std::optional<RestitutionSamples> at_plate;  ///< where these are other than `part`
};

Prepared::Prepared(const RestitutionSamples& samples, const FitConfig& config)
    : part(usable_samples(samples, left_out)) {
  if (part->empty()) return;
  curve.emplace(*part, places_of(*part), config.law.node_speeds_mps);
  const double errors = curve->curve().errors_over_digits.value_or(1.0);
  if (curve->known().is_open() || errors != 1.0)
    at_plate = at_the_plate(with_errors(*part, errors), curve->known(), curve->deviation());
}

/// The law at the nodes of the curve, with its tests.
LawFitConfig main_law(const FitConfig& config, const std::optional<Curve>& curve) {
  LawFitConfig law = config.law;
  law.n_goodness = config.n_goodness;
  if (law.node_speeds_mps.empty() && curve && curve->nodes.size() > 1)
    for (const CurveNode& node : curve->nodes) law.node_speeds_mps.push_back(node.v_mps);
  return law;
}

/// How the samples scatter about the law: histograms, budget, picture. @param kept  samples without the law's outliers
void describe_scatter(FitResult& result, const RestitutionSamples& kept, const Prepared& prepared,
                      const FitConfig& config) {
  result.histograms = fit_histograms(kept, config.histograms, result.law);
  if (prepared.used().size() > kMostShown) result.density = density_picture(prepared.shown());
  result.budget = error_budget(kept, result.law, budget_config_of(*prepared.part, config.budget));
}

FitResult fit_on_these_threads(const RestitutionSamples& samples, const FitConfig& config,
                               const ProgressCallback& progress);

/// The errors of a plate's curve by its recordings, where these differ by more than the drops within them say.
void count_recordings(RecordingFit& plate) {
  const auto n = static_cast<double>(plate.within->offsets.size());
  double mean = 0.0, squares = 0.0;
  for (const NamedEstimate& offset : plate.within->offsets) mean += offset.estimate.value / n;
  for (const NamedEstimate& offset : plate.within->offsets) squares += square(offset.estimate.value - mean);
  const double variance = squares / (n - 1.0) / n;
  for (CurveNode& node : plate.nodes)
    node.eps = student_estimate(node.eps.value, std::max(variance, square(node.eps.se.value_or(0.0))), n - 1.0);
}

/// Each recording by its own curve, at those nodes of the curve of all that it reaches; each plate as alone.
/// @param measured  the samples of all
void describe_rows(Recordings& recordings, const RestitutionSamples& measured, const std::vector<CurveNode>& nodes,
                   const FitConfig& config) {
  std::map<std::string, RestitutionSamples> of;
  for (auto& [name, samples] : by_row(measured, recordings.plates)) of[name] = std::move(samples);
  parallel_for(recordings.rows.size(), 0, [&](std::size_t k) {
    RecordingFit& row = recordings.rows[k];
    const RestitutionSamples& samples = of.at(row.recording);
    std::vector<double> v_mps;
    for (const CurveNode& node : nodes)
      if (node.v_mps >= row.v_lo_mps && node.v_mps <= row.v_hi_mps) v_mps.push_back(node.v_mps);
    if (v_mps.empty()) v_mps = {median(speeds_of(samples))};
    Curve curve;
    if (recordings.plates.empty()) {
      curve = SmoothCurve(samples, places_of(samples), v_mps).curve();
      add_peaks(curve, row.law);
    } else {
      FitConfig alone = config;
      alone.law.node_speeds_mps = v_mps;
      alone.compare_recordings = false;
      alone.n_goodness = 0;
      FitResult one = fit_on_these_threads(samples, alone, {});
      curve = std::move(*one.curve);
      row.parameters = std::move(one.constants.parameters);
      row.with_memory = one.constants.with_memory;
      row.histograms = std::move(one.histograms);
    }
    row.nodes = std::move(curve.nodes);
    if (disagree_within(row)) count_recordings(row);
    row.heights = std::move(curve.heights);
  });
}

/// Are the samples of one ball? With the outliers of the pooled law: they may be all of one recording.
void compare_parts(FitResult& result, const Prepared& prepared, const FitConfig& config) {
  const RestitutionSamples& used = prepared.used();
  if (config.compare_recordings)
    result.recordings = compare_recordings(used, config.law, result.law, config.histograms, config.plates);
  result.recordings.plates = config.plates;
  if (result.curve) describe_rows(result.recordings, *prepared.part, result.curve->nodes, config);
  result.kinds_of_drops = two_kinds_of_drops(used);
  const bool recordings_agree =
      result.recordings.rows.empty() || (result.recordings.test && !disagree(result.recordings));
  result.is_one_ball = config.pool || (recordings_agree && !result.kinds_of_drops);
}

/// What other programs take, and the peak: made of the curve and of the scatter about the law.
void hand_off(FitResult& result, const SampleConditions& conditions, std::optional<double> speed_mps) {
  add_peaks(*result.curve, result.law);
  if (!result.is_one_ball) return;
  const double v_mps = speed_mps.value_or(result.curve->nodes[result.curve->nodes.size() / 2].v_mps);
  std::optional<DemMemory> memory;
  if (memory_holds(result)) memory = DemMemory{*result.memory->law, result.memory->roughness.q.value};
  result.dem_export = dem_export(*result.curve, result.law.scatter, v_mps, conditions.ball, conditions.plate, memory);
}

FitResult fit_on_these_threads(const RestitutionSamples& samples, const FitConfig& config,
                               const ProgressCallback& progress) {
  const double n_steps = config.memory == UseMemory::never ? 5.0 : 6.0;
  auto step = [&, n_done = 0.0]() mutable {
    if (progress) progress(n_done, n_steps);
    n_done += 1.0;
  };
  FitResult result;
  step();
  const Prepared prepared(samples, config);
  const RestitutionSamples& used = prepared.used();
  if (const auto& v_mps = config.dem_speed_mps; v_mps && !used.empty()) {
    const auto [slowest, fastest] =
        std::minmax_element(used.begin(), used.end(), [](const auto& a, const auto& b) { return a.v_mps < b.v_mps; });
    if (*v_mps < slowest->v_mps || *v_mps > fastest->v_mps)
      throw InvalidArgument(
          formatted("--hand-off-speed %.3g m/s: no bounce tells ε there; they are of %.3g to %.3g m/s", *v_mps,
                    slowest->v_mps, fastest->v_mps));
  }
  if (prepared.curve) result.curve = prepared.curve->curve();
  step();
  result.law = fit_law(used, main_law(config, result.curve));
  step();
  if (config.memory != UseMemory::never) {
    // the impacts as they followed each other, outliers among them: where one is missing a chain ends
    if (config.memory == UseMemory::always || drops_are_long(used))
      result.memory = fit_memory(used, result.law, with_memory(config));
    step();
  }
  // what the law cannot explain would widen every other fit
  const PartOfSamples kept(used, result.law.outliers);
  LawFit sphere = config.law.kind == LawKind::viscoelastic ? result.law : fit_law(*kept, viscoelastic(config.law));
  step();
  describe_scatter(result, *kept, prepared, config);
  step();
  compare_parts(result, prepared, config);
  step();
  if (prepared.curve) {
    look_beside(*prepared.curve, result.law, config.law, result.memory ? &*result.memory : nullptr, used);
    look_beside(*prepared.curve, sphere, config.law, nullptr, *kept);
  }
  result.constants = constants_of(result, sphere);
  if (result.curve) hand_off(result, used.front().conditions, config.dem_speed_mps);
  result.n_used = result.law.n;
  result.n_left_out = prepared.left_out.n;
  if (!result.law.outliers.empty()) result.n_left_out["outlier"] = result.law.outliers.size();
  return result;
}

}  // namespace

FitResult fit_all(const RestitutionSamples& samples, const FitConfig& config, const ProgressCallback& progress) {
  check_options(config);
  FitResult result;
  with_threads(config.n_threads, [&] { result = fit_on_these_threads(samples, config, progress); });
  return result;
}

bool memory_holds(const FitResult& result) {
  return result.memory && result.memory->holds && !result.memory->nodes.empty();
}

}  // namespace bouncelab::fit
