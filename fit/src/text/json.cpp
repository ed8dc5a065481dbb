// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace bouncelab::fit {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
Json json_of(std::size_t n) { return n; }
Json json_of(const Interval& i) { return {json_of(i.lo), json_of(i.hi)}; }

Json json_of(const Estimate& e);
Json json_of(const BootstrapErrors& b);
Json json_of(const AndersonDarling& a);
Json json_of(const ScatterModel& s);
Json json_of(const DropCount& d);
Json json_of(const TimingNoise& t);
Json json_of(const DemExport& h);
Json json_of(const RecordingsTest& t);
template <class T>
Json json_of(const std::optional<T>& x) {
  return x ? json_of(*x) : Json(nullptr);
}

Json json_of(const BootstrapErrors& b) {
  return {
      {"se", json_of(b.se)}, {"ci68", json_of(b.ci68)}, {"ci95", json_of(b.ci95)}, {"n_replicates", b.n_replicates}};
}

Json json_of(const AndersonDarling& a) {
  return {{"a2", json_of(a.a2)}, {"p_value", json_of(a.p_value)}, {"n_replicates", a.n_replicates}};
}

Json comparison_of(const std::vector<LawComparison>& comparison) {
  Json rows = Json::array();
  for (const LawComparison& c : comparison)
    rows.push_back({{"name", c.name},
                    {"n_parameters", c.n_parameters},
                    {"loglik", json_of(c.loglik)},
                    {"aic", json_of(c.aic)},
                    {"bic", json_of(c.bic)},
                    {"delta_aic", json_of(c.delta_aic)},
                    {"delta_bic", json_of(c.delta_bic)}});
  return rows;
}

Json json_of(const Estimate& e) {
  return {{"value", json_of(e.value)},
          {"se", json_of(e.se)},
          {"se_independent", json_of(e.se_independent)},
          {"ci68", json_of(e.ci68)},
          {"ci95", json_of(e.ci95)},
          {"intervals", e.interval_method ? to_string(*e.interval_method) : ""},
          {"bootstrap", json_of(e.bootstrap)},
          {"identified", e.identified}};
}

Json json_of(const DropCount& d) { return {{"n", d.n}, {"errors", to_string(d.errors)}}; }

Json json_of(const Matrix& m) {
  Json rows = Json::array();
  for (const auto& row : m) {
    Json cells = Json::array();
    for (const double x : row) cells.push_back(json_of(x));
    rows.push_back(std::move(cells));
  }
  return rows;
}

Json json_of(const ScatterModel& s) {
  return {{"form",
           "log b = sum_k c_k log(v/v_ref)^k, b the means of two exponentials; convolved with a normal of "
           "normal_ratio sqrt(b_below b_above)"},
          {"v_ref_mps", s.v_ref_mps},
          {"log_below", s.log_below},
          {"log_above", s.log_above},
          {"normal_ratio", s.normal_ratio}};
}

Json nodes_of(const std::vector<NodeEstimate>& estimates) {
  Json nodes = Json::array();
  for (const NodeEstimate& node : estimates)
    nodes.push_back({{"v_mps", node.v_mps},
                     {"eps", json_of(node.eps.value)},
                     {"se", json_of(node.eps.se)},
                     {"se_independent", json_of(node.eps.se_independent)},
                     {"ci68", json_of(node.eps.ci68)},
                     {"ci95", json_of(node.eps.ci95)},
                     {"bootstrap", json_of(node.eps.bootstrap)}});
  return nodes;
}

Json curve_of(const std::vector<CurvePoint>& curve) {
  Json points = Json::array();
  for (const CurvePoint& p : curve)
    points.push_back({{"v_mps", p.x},
                      {"eps", json_of(p.y)},
                      {"lo95", p.band95 ? json_of(p.band95->lo) : Json(nullptr)},
                      {"hi95", p.band95 ? json_of(p.band95->hi) : Json(nullptr)}});
  return points;
}

Json residuals_of(const LawFit& fit) {
  Json bins = Json::array();
  for (const ResidualBin& b : fit.residuals)
    bins.push_back({{"v_mps", b.v_mps},
                    {"n", b.n},
                    {"mean_residual", json_of(b.mean_residual)},
                    {"median_residual", json_of(b.median_residual)},
                    {"pull", json_of(b.pull)},
                    {"scatter_ratio", json_of(b.scatter_ratio)}});
  return bins;
}

Json json_of(const LawFit& fit) {
  Json j{{"status", to_string(fit.status)},
         {"message", fit.message},
         {"law", to_string(fit.kind)},
         {"method", to_string(fit.method)},
         {"n", fit.n},
         {"drops", json_of(fit.drops)},
         {"n_outliers", fit.outliers.size()},
         {"n_parameters", fit.n_parameters}};
  for (const NamedEstimate& p : fit.parameters) j[p.name] = json_of(p.estimate);
  Json names = Json::array();
  for (const NamedEstimate& p : fit.parameters) names.push_back(p.name);
  j["parameters"] = names;
  j["correlation"] = json_of(fit.correlation);
  j["covariance"] = json_of(fit.covariance);
  j["condition_number"] = json_of(fit.condition_number);
  j["nodes"] = nodes_of(fit.nodes);
  j["node_correlation"] = json_of(fit.node_correlation);
  j["scatter"] = json_of(fit.scatter);
  j["loglik"] = json_of(fit.loglik);
  j["aic"] = json_of(fit.aic);
  j["bic"] = json_of(fit.bic);
  j["chi2"] = json_of(fit.chi2);
  j["ndf"] = json_of(fit.ndf);
  j["p_value"] = json_of(fit.p_value);
  j["anderson_darling"] = json_of(fit.anderson_darling);
  j["curve"] = curve_of(fit.curve);
  j["residuals"] = residuals_of(fit);
  return j;
}

Json tests_of(const MemoryFit& m) {
  return {{"leak_z", json_of(m.leak.z)},           {"leak_p", json_of(m.leak.p_value)},
          {"release_z", json_of(m.release.z)},     {"release_p", json_of(m.release.p_value)},
          {"mechanism_z", json_of(m.mechanism.z)}, {"mechanism_p", json_of(m.mechanism.p_value)}};
}

Json json_of(const MemoryFit& m) {
  const bool fitted = m.status == FitStatus::ok;
  Json j{{"status", to_string(m.status)}, {"message", m.message},  {"holds", m.holds}, {"n", m.n},
         {"n_drops", m.n_drops},          {"n_chains", m.n_chains}};
  Json names = Json::array();
  for (const NamedEstimate& p : m.parameters) {
    j[p.name] = json_of(p.estimate);
    names.push_back(p.name);
  }
  j["parameters"] = names;
  j["covariance"] = json_of(m.covariance);
  j["nodes"] = nodes_of(m.nodes);
  j["node_correlation"] = json_of(m.node_correlation);
  j["leak"] = fitted ? json_of(leak_of(m)) : Json(nullptr);
  j["release_m2ps2"] = json_of(m.release_m2ps2);
  j["loglik"] = fitted ? json_of(m.loglik) : Json(nullptr);
  j["loglik_independent"] = json_of(m.loglik_independent);
  j["anderson_darling"] = json_of(m.anderson_darling);
  j["transform_counts"] = m.transform_counts;
  j["tests"] = fitted ? tests_of(m) : Json(nullptr);
  j["curve"] = curve_of(m.curve);
  return j;
}

Json roughness_of(const MemoryFit& m, const Roughness& r, double inertia_factor) {
  return {{"q", json_of(r.q.value)},
          {"q_se", json_of(r.q.se)},
          {"q_ci95", json_of(r.q.ci95)},
          {"inertia_factor", inertia_factor},
          {"s2_no_slip", json_of(r.s2_no_slip)},
          {"s2_frictionless", json_of(r.s2_frictionless)},
          {"rms_tilt_no_slip_deg", json_of(r.rms_tilt_no_slip_deg)},
          {"n_constant_radii", json_of(r.n_constant_radii)},
          {"lambda_exponential", json_of(r.lambda_exponential)},
          {"width_uniform_1e6", json_of(r.width_uniform_1e6)},
          {"leak", json_of(leak_of(m))},
          {"mechanism_p", json_of(m.mechanism.p_value)}};
}

Json json_of(const ShapeFit& shape) {
  Json parameters = Json::object();
  for (const NamedEstimate& p : shape.parameters) parameters[p.name] = json_of(p.estimate);
  Json expected = Json::array();
  for (const double n : shape.expected) expected.push_back(json_of(n));
  return {{"shape", to_string(shape.shape)}, {"status", to_string(shape.status)},     {"parameters", parameters},
          {"loglik", json_of(shape.loglik)}, {"delta_aic", json_of(shape.delta_aic)}, {"chi2", json_of(shape.chi2)},
          {"ndf", json_of(shape.ndf)},       {"p_value", json_of(shape.p_value)},     {"expected", expected}};
}

Json json_of(const HistogramFit& h) {
  Json shapes = Json::array();
  for (const ShapeFit& shape : h.shapes) shapes.push_back(json_of(shape));
  Json curve{{"eps", Json::array()}, {"density", Json::array()}};
  for (const CurvePoint& p : h.curve) {
    curve["eps"].push_back(p.x);
    curve["density"].push_back(json_of(p.y));
  }
  return {{"status", to_string(h.status)},
          {"message", h.message},
          {"v_lo_mps", h.v_lo_mps},
          {"v_hi_mps", h.v_hi_mps},
          {"v_mps", h.v_mps},
          {"n", h.n},
          {"drops", json_of(h.drops)},
          {"peak_eps", json_of(h.peak_eps)},
          {"slope_rising", json_of(h.slope_rising)},
          {"slope_falling", json_of(h.slope_falling)},
          {"slope_ratio", json_of(h.slope_ratio)},
          {"p_equal_slopes", json_of(h.p_equal_slopes)},
          {"loglik", json_of(h.loglik)},
          {"chi2", json_of(h.chi2)},
          {"ndf", json_of(h.ndf)},
          {"p_value", json_of(h.p_value)},
          {"delta_aic_gaussian", json_of(h.delta_aic_gaussian)},
          {"bins",
           {{"eps_edges", h.bins.eps_edges},
            {"counts", h.bins.counts},
            {"underflow", h.bins.underflow},
            {"overflow", h.bins.overflow}}},
          {"curve", curve},
          {"shapes", shapes},
          {"verdict", h.verdict}};
}

Json json_of(const TimingNoise& t) {
  return {{"n_pairs", t.n_pairs},
          {"lag1_correlation", json_of(t.lag1_correlation)},
          {"lag1_correlation_se", json_of(t.lag1_correlation_se)},
          {"variance_s2", json_of(t.variance_s2)},
          {"variance_se_s2", json_of(t.variance_se_s2)},
          {"sigma_s", json_of(t.sigma_s)},
          {"upper95_s", json_of(t.upper95_s)},
          {"stated_s", json_of(t.stated_s)}};
}

Json json_of(const BudgetRow& r) {
  return {{"v_mps", r.v_mps},
          {"n", r.n},
          {"spread", json_of(r.spread)},
          {"spread_asperities", json_of(r.spread_asperities)},
          {"spread_timing_stated", json_of(r.spread_timing_stated)},
          {"spread_timing_lag1", json_of(r.spread_timing_lag1)},
          {"spread_travel_time", json_of(r.spread_travel_time)},
          {"share_asperities", json_of(r.share_asperities)},
          {"share_timing", json_of(r.share_timing)},
          {"share_travel_time", json_of(r.share_travel_time)},
          {"share_unexplained", json_of(r.share_unexplained)},
          {"shift_drag", json_of(r.shift_drag)},
          {"shift_contact_time", json_of(r.shift_contact_time)},
          {"mean_minus_peak", json_of(r.mean_minus_peak)},
          {"se_curve", json_of(r.se_curve)}};
}

Json json_of(const ErrorBudget& budget) {
  Json rows = Json::array();
  for (const BudgetRow& r : budget.rows) rows.push_back(json_of(r));
  Json effects = Json::array(), v = Json::array(), spread = Json::array();
  for (const auto& [name, effect] : budget.effects) effects.push_back({{"name", name}, {"state", to_string(effect)}});
  for (const CurvePoint& p : budget.width_law) {
    v.push_back(p.x);
    spread.push_back(json_of(p.y));
  }
  return {{"timing", json_of(budget.timing)},
          {"width_exponent", json_of(budget.width_exponent)},
          {"width_law", {{"v_mps", v}, {"spread", spread}}},
          {"effects", effects},
          {"rows", rows}};
}

Json json_of(const DemExport& h) {
  Json snippets = Json::array();
  for (const Snippet& s : h.snippets)
    snippets.push_back({{"program", s.program}, {"parameter", s.parameter}, {"text", s.text}});
  return {{"v_mps", h.v_mps},
          {"eps", json_of(h.eps)},
          {"se", json_of(h.se)},
          {"warning", h.warning},
          {"snippets", snippets}};
}

Json json_of(const RecordingsTest& t) {
  return {{"n_recordings", t.n_recordings},
          {"likelihood_ratio", json_of(t.likelihood_ratio)},
          {"f", json_of(t.f)},
          {"ndf", json_of(t.ndf)},
          {"ndf_within", json_of(t.ndf_within)},
          {"within", to_string(t.within)},
          {"p_value", json_of(t.p_value)}};
}

Json json_of(const RecordingFit& r) {
  Json j{{"recording", r.recording},
         {"status", to_string(r.status)},
         {"message", r.message},
         {"law", to_string(r.kind)},
         {"n", r.n},
         {"n_outliers", r.n_outliers},
         {"n_drops", r.n_drops},
         {"v_lo_mps", r.v_lo_mps},
         {"v_hi_mps", r.v_hi_mps},
         {"offset", json_of(r.offset)},
         {"nodes", nodes_of(r.nodes)}};
  Json names = Json::array();
  for (const NamedEstimate& p : r.parameters) {
    j[p.name] = json_of(p.estimate);
    names.push_back(p.name);
  }
  j["parameters"] = names;
  return j;
}

}  // namespace

std::string to_json(const FitResult& result, int indent) {
  Json histograms = Json::array();
  for (const HistogramFit& h : result.histograms) histograms.push_back(json_of(h));
  Json recordings = Json::array();
  for (const RecordingFit& r : result.recordings.rows) recordings.push_back(json_of(r));
  Json answers = Json::array();
  for (const Finding& a : result.findings) answers.push_back({{"question", a.question}, {"answer", a.answer}});
  Json j{{"status", to_string(result.status)},
         {"warnings", result.warnings},
         {"answers", answers},
         {"n_used", result.n_used},
         {"n_left_out", result.n_left_out},
         {"law", json_of(result.law)},
         {"recordings_test", json_of(result.recordings.test)},
         {"recordings", recordings},
         {"law_least_squares", json_of(result.law_least_squares)},
         {"law_least_absolute", json_of(result.law_least_absolute)},
         {"law_comparison", comparison_of(result.law.comparison)},
         {"law_viscoelastic", json_of(result.law_viscoelastic)},
         {"histograms", histograms},
         {"budget", json_of(result.budget)},
         {"hand_off", json_of(result.dem_export)},
         {"density",
          {{"v_edges_mps", result.density.v_edges_mps},
           {"eps_edges", result.density.eps_edges},
           {"counts", result.density.counts},
           {"n_outside", result.density.n_outside}}}};
  if (const std::optional<MemoryFit>& memory = result.memory) {
    j["memory"] = json_of(*memory);
    j["roughness"] =
        memory->status == FitStatus::ok ? roughness_of(*memory, memory->roughness, kSolidBallInertia) : Json(nullptr);
  }
  return j.dump(indent) + "\n";
}

std::string to_json(const RoughnessResult& result, int indent) {
  const MemoryFit& m = result.memory;
  Json j{{"status", to_string(m.status)},
         {"message", m.message},
         {"holds", m.holds},
         {"warnings", result.warnings},
         {"n", m.n},
         {"n_drops", m.n_drops},
         {"n_chains", m.n_chains},
         {"n_left_out", result.n_left_out}};
  const bool fitted = m.status == FitStatus::ok;
  j["roughness"] = fitted ? roughness_of(m, result.surface, result.inertia_factor) : Json(nullptr);
  j["tests"] = fitted ? tests_of(m) : Json(nullptr);
  j["anderson_darling"] = json_of(m.anderson_darling);
  return j.dump(indent) + "\n";
}

}  // namespace bouncelab::fit
