// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bouncelab/core/onsets.hpp"

namespace bouncelab {
namespace {

std::string words(const char* format, double a, double b = 0.0) {
  char text[240];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// Why a sample cannot be used; empty: it can. The first flag names the reason.
std::string reason_to_leave_out(const RestitutionSample& s) {
  if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) return "not_finite";
  if (!(s.v_mps > 0.0)) return "speed_not_positive";
  return s.flags.substr(0, s.flags.find('|'));
}

RestitutionSamples usable_samples(const RestitutionSamples& samples, std::map<std::string, std::size_t>& left_out) {
  RestitutionSamples used;
  for (const RestitutionSample& s : samples) {
    const std::string reason = reason_to_leave_out(s);
    if (reason.empty())
      used.push_back(s);
    else
      ++left_out[reason];
  }
  return used;
}

LawFitConfig alternative(const LawFitConfig& main, LawKind kind, LawMethod method, const LawFit& fitted) {
  LawFitConfig config = main;
  config.kind = kind;
  config.method = method;
  // the normal's profile is its covariance to all practical purposes
  if (method == LawMethod::least_squares) config.intervals = IntervalMethod::covariance;
  for (const NodeEstimate& node : fitted.nodes)
    if (main.node_speeds_mps.empty()) config.node_speeds_mps.push_back(node.v_mps);
  return config;
}

/// One line for all pairs: the worst one stands for them.
void warn_of_correlation(const LawFit& law, std::vector<std::string>& warnings) {
  std::size_t worst_i = 0, worst_j = 0;
  double worst = 0.99;
  for (std::size_t i = 0; i < law.parameters.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::abs(law.correlation[i][j]) > worst) {
        worst = std::abs(law.correlation[i][j]);
        worst_i = i;
        worst_j = j;
      }
  if (worst_i == worst_j) return;
  warnings.push_back(law.parameters[worst_j].name + " and " + law.parameters[worst_i].name +
                     words(" cannot be told apart with these speeds: their correlation is %.4f; quote eps(v) at the "
                           "nodes, or the constants with their covariance",
                           law.correlation[worst_i][worst_j]));
}

void warn_of_law(const LawFit& law, std::vector<std::string>& warnings) {
  if (!law.message.empty()) warnings.push_back(law.message);
  warn_of_correlation(law, warnings);
  if (law.p_value && *law.p_value < 0.001) {
    double ratio = 0.0;
    for (const ResidualBin& bin : law.residuals) ratio += bin.scatter_ratio / static_cast<double>(law.residuals.size());
    warnings.push_back(words("the scatter about eps(v) is not as the fit assumes: chi2 / ndf = %.2f, p = %.1e; ",
                             *law.chi2 / static_cast<double>(*law.ndf), *law.p_value) +
                       (ratio < 0.8 ? words("it is %.2f of what the stated timing errors alone explain: these are "
                                            "stated too large, and so are all errors given here",
                                            ratio)
                                    : "standard errors may be too small; se_robust does not depend on it"));
  }
  if (law.n_outliers > 0)
    warnings.push_back(std::to_string(law.n_outliers) +
                       " samples lie further from eps(v) than the scatter can put "
                       "them and were left out: missed or invented impacts?");
}

/// Where the noise that neighbouring samples share is not what the detector states.
void warn_of_timing(const ErrorBudget& budget, std::vector<std::string>& warnings) {
  if (!budget.timing || !budget.timing->stated_s || !(*budget.timing->stated_s > 0.0)) return;
  const TimingNoise& t = *budget.timing;
  const double stated2 = *t.stated_s * *t.stated_s;
  if (std::abs(t.variance_s2 - stated2) < 4.0 * t.variance_se_s2 || !t.sigma_s) return;
  // a tenth of the noise is of no consequence however well it is measured
  if (std::abs(*t.sigma_s / *t.stated_s - 1.0) < 0.1) return;
  warnings.push_back(words("neighbouring samples show a timing noise of %.2g us where %.2g us are stated",
                           *t.sigma_s * 1e6, *t.stated_s * 1e6));
}

void warn_of_samples(const RestitutionSamples& used, std::vector<std::string>& warnings) {
  const auto count = [&](auto&& condition) {
    return static_cast<double>(std::count_if(used.begin(), used.end(), condition));
  };
  const double n = static_cast<double>(used.size());
  const double unknown = count([](const auto& s) { return !s.sigma_eps || !(*s.sigma_eps > 0.0); });
  if (unknown > 0.0)
    warnings.push_back(
        words("%.0f of %.0f samples state no timing error: it is neglected there, and the scatter "
              "includes it",
              unknown, n));
  const double above_one = count([](const auto& s) { return s.eps > 1.0; });
  if (above_one > 0.1 * n)
    warnings.push_back(words("%.0f of %.0f samples have eps > 1: time order or units of the input?", above_one, n));
  const double implausible = count([](const auto& s) { return s.v_mps > 20.0 || s.v_mps < 0.005; });
  if (implausible > 0.1 * n)
    warnings.push_back(
        words("%.0f of %.0f speeds are outside 0.005 to 20 m/s: are the times in seconds?", implausible, n));
}

}  // namespace

FitResult fit_all(const RestitutionSamples& samples, const FitConfig& config, const ProgressCallback& progress) {
  constexpr double kSteps = 4.0;
  const auto step = [&](double done) {
    if (progress) progress(done, kSteps);
  };
  FitResult result;
  const RestitutionSamples used = usable_samples(samples, result.n_left_out);
  step(0.0);
  result.law = fit_law(used, config.law);
  step(1.0);
  result.law_least_squares =
      fit_law(used, alternative(config.law, config.law.kind, LawMethod::least_squares, result.law));
  step(2.0);
  result.law_viscoelastic =
      fit_law(used, alternative(config.law, LawKind::viscoelastic, config.law.method, result.law));
  step(3.0);
  result.histograms = fit_histograms(used, config.histograms, result.law);
  result.density = density_picture(used);
  result.budget = error_budget(used, result.law, config.budget);
  step(kSteps);
  if (!result.law.nodes.empty())
    result.hand_off =
        hand_off(result.law, config.hand_off_speed_mps.value_or(result.law.nodes[result.law.nodes.size() / 2].v_mps));
  result.status = result.law.status;
  result.n_used = result.law.n;
  if (result.law.n_outliers > 0) result.n_left_out["outlier"] = result.law.n_outliers;
  warn_of_law(result.law, result.warnings);
  warn_of_timing(result.budget, result.warnings);
  warn_of_samples(used, result.warnings);
  return result;
}

bool usable(const FitResult& result) {
  return (result.status == FitStatus::ok || result.status == FitStatus::not_identifiable) && !result.law.nodes.empty();
}

}  // namespace bouncelab
