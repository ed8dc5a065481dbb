// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/answer.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/text.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

/// Windows with a fit.
std::vector<const HistogramFit*> fitted(const FitResult& result) {
  std::vector<const HistogramFit*> windows;
  for (const HistogramFit& h : result.histograms)
    if (h.peak_eps && h.slope_rising && h.slope_falling) windows.push_back(&h);
  return windows;
}

Conclusion not_normal(const FitResult& rough) {
  Conclusion c{"p(ε) at fixed speed is not normal", "smallest AIC(normal) − AIC(two exponentials) of the windows",
               "above 10 in every window"};
  double largest_p = 0.0;
  for (const HistogramFit* h : fitted(rough)) {
    if (!h->normal) continue;
    if (!c.value || h->normal->delta_aic < *c.value)
      c.value = h->normal->delta_aic, c.detail = formatted("smallest at %.1f m/s", h->v_mps);
    if (h->normal->pearson) largest_p = std::max(largest_p, h->normal->pearson->p_value);
  }
  c.holds = c.value && *c.value > 10.0;
  if (c.value) c.detail += formatted("; largest p-value of a normal (Pearson's χ²) %.2g", largest_p);
  return c;
}

Conclusion two_slopes(const FitResult& rough) {
  Conclusion c{"its two slopes differ, the low side reaching further",
               "falling over rising slope, in the window where they differ least",
               "95% interval above 1 in every window"};
  for (const HistogramFit* h : fitted(rough)) {
    if (!h->slope_ratio || !h->slope_ratio->ci95) continue;
    if (c.ci95 && h->slope_ratio->ci95->lo >= c.ci95->lo) continue;
    c.value = h->slope_ratio->value;
    c.ci95 = h->slope_ratio->ci95;
    c.detail = formatted("least at %.1f m/s: %.0f rising, %.0f falling", h->v_mps, h->slope_rising->value,
                         h->slope_falling->value);
  }
  c.holds = c.ci95 && c.ci95->lo > 1.0;
  return c;
}

Conclusion peaks_follow_the_law(const FitResult& rough, const std::optional<RestitutionLaw>& truth) {
  Conclusion c{"its peaks follow ε(v)",
               truth ? "largest |peak − ε(v) that went in| over its standard error"
                     : "largest |peak − fitted ε(v)| over its standard error",
               "below 3 in every window"};
  const std::optional<RestitutionLaw>& law = truth ? truth : rough.law.law;
  if (!law) return c;
  double square = 0.0, n = 0.0;
  for (const HistogramFit* h : fitted(rough)) {
    if (!h->peak_eps->se || !(*h->peak_eps->se > 0.0)) continue;
    const double off = h->peak_eps->value - restitution(*law, h->v_mps), pull = off / *h->peak_eps->se;
    square += pull * pull;
    n += 1.0;
    if (!c.value || std::abs(pull) > *c.value)
      c.value = std::abs(pull), c.detail = formatted("largest at %.1f m/s: %+.2g off", h->v_mps, off);
  }
  if (n > 0.0) c.detail += formatted("; root mean square of %.0f pulls %.2f", n, std::sqrt(square / n));
  c.holds = c.value && *c.value < 3.0;
  return c;
}

Conclusion asperities_scatter(const FitResult& rough, const FitResult& smooth) {
  Conclusion c{"the scatter comes from the asperities",
               "spread of the smooth ball over that of the rough one, where it is largest", "below 0.1 at every speed"};
  for (const BudgetRow& row : rough.budget.rows) {
    const auto same = std::min_element(
        smooth.budget.rows.begin(), smooth.budget.rows.end(),
        [&](const auto& a, const auto& b) { return std::abs(a.v_mps - row.v_mps) < std::abs(b.v_mps - row.v_mps); });
    if (same == smooth.budget.rows.end() || !(row.spread > 0.0)) continue;
    const double ratio = same->spread / row.spread;
    if (!c.value || ratio > *c.value)
      c.value = ratio,
      c.detail = formatted("largest at %.2f m/s: %.2g against %.2g", row.v_mps, same->spread, row.spread);
  }
  c.holds = c.value && *c.value < 0.1;
  return c;
}

Conclusion scatter_grows(const FitResult& rough) {
  Conclusion c{"the scatter grows as the speed falls", "k of spread ∝ v^k", "95% interval below 0"};
  const std::optional<Estimate>& k = rough.budget.width_exponent;
  if (!k) return c;
  c.value = k->value;
  c.ci95 = k->ci95;
  c.holds = k->ci95 && k->ci95->hi < 0.0;
  if (const auto& rows = rough.budget.rows; !rows.empty())
    c.detail = formatted("spread %.2g at %.2f m/s, %.2g at %.2f m/s", rows.front().spread, rows.front().v_mps,
                         rows.back().spread, rows.back().v_mps);
  return c;
}

}  // namespace

std::vector<Conclusion> paper_conclusions(const FitResult& rough, const FitResult* smooth,
                                          const std::optional<RestitutionLaw>& truth) {
  std::vector<Conclusion> all{not_normal(rough), two_slopes(rough), peaks_follow_the_law(rough, truth)};
  if (smooth != nullptr) all.push_back(asperities_scatter(rough, *smooth));
  all.push_back(scatter_grows(rough));
  return all;
}

Description members_of(const Conclusion*) {
  using C = Conclusion;
  static constexpr Member all[]{member<&C::claim>("claim", "What the paper says"),
                                member<&C::measure>("measure", "What `value` is"),
                                member<&C::criterion>("criterion", "When the claim is said to hold"),
                                member<&C::holds>("holds", "Whether it does"),
                                member<&C::detail>("detail", "The numbers behind, in words"),
                                member<&C::value>("value", "`null` where the data do not reach"),
                                member<&C::ci95>("ci95", "Its 95 % interval")};
  return all;
}

}  // namespace bouncelab::report
