// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "law/goodness.hpp"
#include "law/intervals.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// The law's coordinates q with their covariance: by drop where there is such, else of independent samples.
struct ParameterCovariance {
  Eigen::VectorXd q;
  Eigen::MatrixXd covariance;
  std::optional<Eigen::MatrixXd> independent;  ///< where `covariance` is by drop
  ProfileLevels reach;                         ///< of intervals by covariance, in standard errors

  /// Value with errors of a function whose gradient by q is `row`.
  Estimate estimate(double value, const Eigen::RowVectorXd& row) const {
    Estimate e = normal_estimate(value, std::sqrt(congruence(row.transpose(), covariance)(0, 0)), reach.z68, reach.z95);
    if (independent) e.se_independent = std::sqrt(congruence(row.transpose(), *independent)(0, 0));
    return e;
  }
};

/// With fewer samples per parameter the information matrix describes the likelihood badly: single samples are its
/// grain.
constexpr std::size_t kSamplesPerParameter = 30;

/// A parameter is identified when it is known to a third of itself, or its term C_i A_i v^(i/10) is known, in the
/// middle of the data, to within the whole loss 1 - eps that the series has to explain. Constants of a series of
/// several terms need, besides, 30 samples for each parameter of law and scatter.
bool is_identified(const LawModel& model, Eigen::Index i, const Estimate& a, double v_mps, double eps) {
  if (!a.se || !std::isfinite(*a.se)) return false;
  const double se = std::max(*a.se, a.se_independent.value_or(0.0));
  if (3.0 * se < std::abs(a.value) || model.kind != LawKind::series) return true;
  const int order = model.orders[static_cast<std::size_t>(i)];
  const double of_term = std::abs(kViscoelasticC[static_cast<std::size_t>(order)]) * pow(v_mps, 0.1 * order);
  return se * of_term < std::abs(1.0 - eps);
}

/// Parameters tied to one that is not identified by a correlation above .99 are not identified either: the
/// likelihood determines their sum only.
void propagate_unidentified(std::vector<NamedEstimate>& parameters, const Eigen::MatrixXd& correlation) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      for (std::size_t j = 0; j < parameters.size(); ++j) {
        const bool tied = std::abs(correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j))) > 0.99;
        if (!tied || parameters[i].estimate.identified || !parameters[j].estimate.identified) continue;
        parameters[j].estimate.identified = false;
        changed = true;
      }
    }
  }
}

void describe_parameters(LawFit& fit, const LawLikelihood& likelihood, const ParameterCovariance& known) {
  const LawModel& model = likelihood.model();
  const Eigen::VectorXd& q = known.q;
  const Eigen::MatrixXd j = model.reported_jacobian(q);
  const Eigen::MatrixXd covariance = congruence(j.transpose(), known.covariance);
  const Eigen::VectorXd values = model.reported(q);
  const auto& v = likelihood.data().v_mps;
  const double v_middle = v[v.size() / 2];
  const double eps_middle = model.eps(std::span(&v_middle, 1), q)[0];
  const auto names = model.names();
  const bool enough = fit.n >= kSamplesPerParameter * fit.n_parameters;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    fit.parameters.push_back({names[static_cast<std::size_t>(i)], known.estimate(values[i], j.row(i))});
  mark_identified(fit.parameters, model, correlation_of(covariance), v_middle, eps_middle);
  if (values.size() > 1 && !enough)
    for (NamedEstimate& p : fit.parameters) p.estimate.identified = false;
  fit.covariance = to_matrix(covariance);
  fit.why = not_identified(fit.parameters, fit.n);
  if (fit.why) fit.status = FitStatus::not_identifiable;
}

void describe_nodes(LawFit& fit, const LawModel& model, const ParameterCovariance& known,
                    const std::vector<double>& node_speeds_mps) {
  const Eigen::VectorXd& q = known.q;
  const Eigen::MatrixXd node_rows = model.jacobian(node_speeds_mps, q);
  const Eigen::MatrixXd node_covariance = congruence(node_rows.transpose(), known.covariance);
  const Eigen::VectorXd node_eps = model.eps(node_speeds_mps, q);
  for (Eigen::Index j = 0; j < node_eps.size(); ++j)
    fit.nodes.push_back({node_speeds_mps[static_cast<std::size_t>(j)], known.estimate(node_eps[j], node_rows.row(j))});
  fit.node_covariance = to_matrix(node_covariance);
}

void describe_goodness(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum) {
  fit.loglik = maximum.loglik;
  constexpr double kFewestDegrees = 5.0;  // of fewer chi^2 says nothing
  fit.pearson = pearson_chi2(likelihood.probabilities_below(maximum.x), fit.n_parameters);
  if (fit.pearson && fit.pearson->ndf < kFewestDegrees) fit.pearson.reset();
  fit.residuals = residual_bins(likelihood, maximum.x);
}

/// Replaces the intervals of constants and nodes by those of the profile, where it closes.
void profile_all(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum, const Eigen::MatrixXd& white,
                 const std::optional<JackknifeErrors>& by_drop) {
  const LawModel& model = likelihood.model();
  const Eigen::Index n_law = model.n_parameters();
  const Eigen::VectorXd q = maximum.x.head(n_law);
  const ProfileLevels of_samples = profile_levels(fit.n, static_cast<std::size_t>(n_law));
  const auto along = [&](const Eigen::RowVectorXd& row) {
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(maximum.x.size());
    direction.head(n_law) = row.transpose();
    return profile_intervals(std::cref(likelihood), maximum, white, direction,
                             by_drop ? by_drop->profile_levels_of(direction, white) : of_samples,
                             by_drop ? &by_drop->curvature : nullptr);
  };
  // one coordinate: everything reported is a monotone function of it
  const auto one = n_law == 1 ? along(Eigen::RowVectorXd::Ones(1)) : std::nullopt;
  const auto set = [&](Estimate& e, const Eigen::RowVectorXd& row, auto&& value_of) {
    const auto offsets = n_law == 1 ? one : along(row);
    if (!offsets) return;
    const auto end = [&](double offset) {
      return n_law == 1 ? value_of(Eigen::VectorXd::Constant(1, q[0] + offset)) : e.value + offset;
    };
    const auto ordered = [&](const Interval& i) {
      const double a = end(i.lo), b = end(i.hi);
      return Interval{std::min(a, b), std::max(a, b)};
    };
    e.ci68 = ordered(offsets->offset68);
    e.ci95 = ordered(offsets->offset95);
  };
  const Eigen::MatrixXd rows = model.reported_jacobian(q);
  for (std::size_t i = 0; i < fit.parameters.size(); ++i)
    set(fit.parameters[i].estimate, rows.row(static_cast<Eigen::Index>(i)),
        [&](const Eigen::VectorXd& x) { return model.reported(x)[0]; });
  for (NodeEstimate& node : fit.nodes)
    set(node.eps, model.jacobian(std::span(&node.v_mps, 1), q).row(0),
        [&](const Eigen::VectorXd& x) { return model.eps(std::span(&node.v_mps, 1), x)[0]; });
}

/// The law's coordinates with their errors, and what these rest on.
struct Known {
  Eigen::MatrixXd white;
  std::optional<JackknifeErrors> by_drop;
  ParameterCovariance parameters;
};
Known known_of(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum) {
  fit.status = FitStatus::ok;
  const Eigen::Index n_law = likelihood.model().n_parameters();
  Known known{whitening(likelihood.information(maximum.x), 1e-10), std::nullopt, {}};
  fit.n_parameters = static_cast<std::size_t>(likelihood.n_parameters());
  // what p fitted parameters take from the scatter that errors are judged by
  const auto n = static_cast<double>(fit.n), p = static_cast<double>(fit.n_parameters);
  known.parameters.q = maximum.x.head(n_law);
  known.parameters.covariance = n / std::max(1.0, n - p) * gram(known.white).topLeftCorner(n_law, n_law);
  known.by_drop = errors_by_drop(likelihood, maximum.x, known.white);
  fit.drops = {likelihood.n_drops(), known.by_drop ? ErrorBasis::by_drop : ErrorBasis::independent_samples};
  if (likelihood.n_drops() < kFewestDrops && (known.by_drop = errors_by_sample(likelihood, maximum.x, known.white)))
    fit.drops.errors = ErrorBasis::by_sample;
  if (known.by_drop) {
    known.parameters.independent = std::move(known.parameters.covariance);
    known.parameters.covariance = known.by_drop->covariance().topLeftCorner(n_law, n_law);
    known.parameters.reach = known.by_drop->reach();
  }
  return known;
}

}  // namespace

void mark_identified(std::vector<NamedEstimate>& parameters, const LawModel& model, const Eigen::MatrixXd& correlation,
                     double v_mps, double eps) {
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i].estimate.identified =
        is_identified(model, static_cast<Eigen::Index>(i), parameters[i].estimate, v_mps, eps);
  propagate_unidentified(parameters, correlation);
}

std::optional<Note> not_identified(const std::vector<NamedEstimate>& parameters, std::size_t n) {
  std::string intervals;
  for (const NamedEstimate& p : parameters)
    if (!p.estimate.identified)
      intervals += (intervals.empty() ? "" : ", ") + p.name +
                   formatted(" %.3g to %.3g", p.estimate.ci95->lo, p.estimate.ci95->hi);
  if (intervals.empty()) return std::nullopt;
  return Note{NoteKind::not_identifiable, {static_cast<double>(n)}, intervals};
}

void describe_fit(LawFit& fit, const LawLikelihood& likelihood, const Maximum& maximum,
                  const std::vector<double>& node_speeds_mps, IntervalMethod intervals) {
  const Known found = known_of(fit, likelihood, maximum);
  const ParameterCovariance& known = found.parameters;
  fit.scatter = likelihood.scatter_model(maximum.x);
  fit.law = likelihood.model().law(known.q);
  describe_parameters(fit, likelihood, known);
  describe_nodes(fit, likelihood.model(), known, node_speeds_mps);
  describe_goodness(fit, likelihood, maximum);
  if (intervals == IntervalMethod::profile && maximum.converged)
    profile_all(fit, likelihood, maximum, found.white, found.by_drop);
  if (!maximum.converged) {
    fit.status = FitStatus::not_converged;
    fit.why = Note{NoteKind::not_converged, {maximum.gain_left}};
  }
}

}  // namespace bouncelab::fit
