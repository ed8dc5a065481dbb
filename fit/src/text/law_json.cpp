// SPDX-License-Identifier: GPL-3.0-or-later
#include "text/json_parts.hpp"

namespace bouncelab::fit {

Json json_of(const ScatterModel& s) {
  return {{"form",
           "log b = sum_k c_k log(v/v_ref)^k, b the means of two exponentials; convolved with a normal of "
           "normal_ratio sqrt(b_below b_above)"},
          {"v_ref_mps", s.v_ref_mps},
          {"log_below", s.log_below},
          {"log_above", s.log_above},
          {"normal_ratio", s.normal_ratio}};
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

}  // namespace bouncelab::fit
