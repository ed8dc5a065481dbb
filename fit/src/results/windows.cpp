// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of windows of speed and of the budget are called and what they are, key by key (docs/formats.md is
// made of these texts).
#include "bouncelab/fit/error_budget.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

Object by_name(const std::vector<NamedEstimate>& parameters) {
  Object all;
  for (const NamedEstimate& p : parameters) all.emplace_back(p.name, value_of(p.estimate));
  return all;
}

/// The points of a curve as two lists.
static Object as_columns(const std::vector<CurvePoint>& curve, const std::string& x, const std::string& y) {
  std::vector<double> xs, ys;
  for (const CurvePoint& p : curve) {
    xs.push_back(p.x);
    ys.push_back(p.y);
  }
  return {{x, value_of(xs)}, {y, value_of(ys)}};
}

Description members_of(const ChiSquareTest*) {
  using C = ChiSquareTest;
  static constexpr Member all[]{member<&C::chi2>("chi2", "χ²"), member<&C::ndf>("ndf", "Its degrees of freedom"),
                                member<&C::p_value>("p_value", "Its p")};
  return all;
}

Description members_of(const NormalFit*) {
  using N = NormalFit;
  static constexpr Member all[]{
      member<&N::mean>("mean", "Estimate"), member<&N::sd>("sd", "Estimate"),
      member<&N::delta_aic>("delta_aic", "AIC less that of the two exponentials; positive: the normal is worse"),
      member<&N::pearson>("pearson", "As of the two exponentials"),
      member<&N::expected>("expected", "Counts that it expects in the bins")};
  return all;
}

Description members_of(const HistogramFit*) {
  using H = HistogramFit;
  static constexpr Member all[]{
      member<&H::status>("status", "How the fit ended"),
      member<&H::v_lo_mps>("v_lo_mps", "Window"),
      member<&H::v_hi_mps>("v_hi_mps", "Its other end"),
      member<&H::v_mps>("v_mps", "Its centre"),
      member<&H::n>("n", "Samples"),
      member<&H::drops>("drops", "Drops that have samples in the window"),
      member<&H::peak_eps>("peak_eps", "Estimate"),
      member<&H::slope_rising>("slope_rising", "Estimate of the slope below the peak, per unit ε, positive"),
      member<&H::slope_falling>("slope_falling", "Likewise above it"),
      member<&H::slope_ratio>("slope_ratio", "Estimate of falling over rising"),
      member<&H::loglik>("loglik", "Log-likelihood"),
      member<&H::pearson>("pearson", "`{chi2, ndf, p_value}`: Pearson's test in bins of equal probability"),
      member<&H::bins>("bins", "`eps_edges`, `counts`, `underflow`, `overflow`"),
      computed(
          "curve", [](const H& h) { return as_columns(h.curve, "eps", "density"); },
          "`eps`, `density`: the fitted density with the timing errors"),
      member<&H::normal>("normal", "`null`, or a normal distribution of the same samples, see below")};
  return all;
}

Description slopes_of(const HistogramFit* h) { return members_of(h).subspan(1, 9); }

Description members_of(const Bins*) {
  static constexpr Member all[]{member<&Bins::eps_edges>("eps_edges", "Edges of the bins"),
                                member<&Bins::counts>("counts", "Samples in each"),
                                member<&Bins::underflow>("underflow", "Samples below the first edge"),
                                member<&Bins::overflow>("overflow", "Samples above the last edge")};
  return all;
}

Description members_of(const DensityPicture*) {
  using D = DensityPicture;
  static constexpr Member all[]{
      member<&D::v_edges_mps>("v_edges_mps", "Edges of the bins in speed"), member<&D::eps_edges>("eps_edges", "In ε"),
      member<&D::counts>("counts", "`counts[eps bin][v bin]`"), member<&D::n_outside>("n_outside", "Samples outside")};
  return all;
}

Description members_of(const TimingNoise*) {
  using T = TimingNoise;
  static constexpr Member all[]{
      member<&T::n_pairs>("n_pairs", "Neighbouring samples"),
      member<&T::lag1_correlation>("lag1_correlation", "Of their residuals: 0 asperities only, -2/3 timing only"),
      member<&T::lag1_correlation_se>("lag1_correlation_se", "Its standard error"),
      member<&T::sigma_s>("sigma_s", "Standard deviation of a time that they show; `null`: none is seen"),
      member<&T::upper95_s>("upper95_s", "One-sided 95 % limit"),
      member<&T::stated_s>("stated_s", "Median of what `sigma_eps` states")};
  return all;
}

Description members_of(const BudgetRow*) {
  using B = BudgetRow;
  static constexpr Member all[]{
      member<&B::v_mps>("v_mps", "Speed"),
      member<&B::n>("n", "Samples"),
      member<&B::spread>("spread", "Standard deviation of ε - ε(v)"),
      member<&B::spread_asperities>("spread_asperities", "What the fit finds of the ball"),
      member<&B::spread_timing_stated>("spread_timing_stated", "By `sigma_eps`"),
      member<&B::spread_timing_lag1>("spread_timing_lag1", "By `timing`"),
      member<&B::spread_travel_time>("spread_travel_time", "By the travel time of the sound"),
      member<&B::share_asperities>("share_asperities",
                                   "Share of the variance that the ball has; the four shares sum to 1"),
      member<&B::share_timing>("share_timing", "That of the times"),
      member<&B::share_travel_time>("share_travel_time", "That of the travel time"),
      member<&B::share_unexplained>("share_unexplained", "The rest"),
      member<&B::shift_drag>("shift_drag",
                             "Shift of ε by air drag, which is taken out; `null` where the ball is not known"),
      member<&B::shift_contact_time>("shift_contact_time", "Likewise by the duration of contact"),
      member<&B::mean_minus_peak>("mean_minus_peak", "What least squares would be off by")};
  return all;
}

Description members_of(const ErrorBudget*) {
  using B = ErrorBudget;
  static constexpr Member all[]{
      member<&B::timing>("timing", "`null`, or the timing noise that neighbouring samples show, see below"),
      member<&B::width_exponent>("width_exponent", "Estimate of k in spread ∝ v^k"),
      computed(
          "width_law", [](const B& b) { return as_columns(b.width_law, "v_mps", "spread"); },
          "`{v_mps, spread}` at both ends"),
      computed(
          "ball", [](const B& b) { return b.ball ? std::optional(to_text(*b.ball)) : std::nullopt; },
          "That the shifts are for; `null`: not named"),
      computed(
          "plate", [](const B& b) { return b.plate ? std::optional(plate_text(*b.plate)) : std::nullopt; }, "Likewise"),
      member<&B::rows>("rows", "Bins of speed, see below")};
  return all;
}

}  // namespace bouncelab::fit
