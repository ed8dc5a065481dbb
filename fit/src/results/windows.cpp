// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of windows of speed and of the budget are called and what they are, key by key (docs/formats.md is
// made of these texts).
#include "bouncelab/fit/error_budget.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

namespace {

Object by_name(const std::vector<NamedEstimate>& parameters) {
  Object all;
  for (const NamedEstimate& p : parameters) all.emplace_back(p.name, value_of(p.estimate));
  return all;
}

}  // namespace

Object as_columns(const std::vector<CurvePoint>& curve, const std::string& x, const std::string& y) {
  std::vector<double> xs, ys;
  for (const CurvePoint& p : curve) {
    xs.push_back(p.x);
    ys.push_back(p.y);
  }
  return {{x, value_of(xs)}, {y, value_of(ys)}};
}

const Description& members_of(const ShapeFit*) {
  using S = ShapeFit;
  static const Description all{
      result("shape", &S::shape,
             "`two_exponentials` (`peak_eps`, `slope_rising`, `slope_falling`), `normal` (`mean`, `sd`), `gumbel` "
             "(`mode`, `scale`) "
             "or `student_t` (`location`, `scale`, `nu`)"),
      result("status", &S::status, "How its fit ended"),
      result<S>(
          "parameters", [](const S& s) { return by_name(s.parameters); }, "An estimate each, by name"),
      result("loglik", &S::loglik, "Log-likelihood of the counts"),
      result("delta_aic", &S::delta_aic, "AIC less that of the two exponentials"),
      result("chi2", &S::chi2, "Pearson's test"),
      result("ndf", &S::ndf, "Its degrees of freedom"),
      result("p_value", &S::p_value, "Its p"),
      result("expected", &S::expected, "Counts that it expects")};
  return all;
}

const Description& members_of(const HistogramFit*) {
  using H = HistogramFit;
  static const Description all{
      result("status", &H::status, "How the fit ended"),
      result("message", &H::message, "In words, empty where all is well"),
      result("v_lo_mps", &H::v_lo_mps, "Window"),
      result("v_hi_mps", &H::v_hi_mps, "Its other end"),
      result("v_mps", &H::v_mps, "Its centre"),
      result("n", &H::n, "Samples"),
      result("drops", &H::drops, "Drops that have samples in the window"),
      result("peak_eps", &H::peak_eps, "Estimate"),
      result("slope_rising", &H::slope_rising, "Estimate of the slope below the peak, per unit ε, positive"),
      result("slope_falling", &H::slope_falling, "Likewise above it"),
      result("slope_ratio", &H::slope_ratio, "Estimate of falling over rising"),
      result("p_equal_slopes", &H::p_equal_slopes,
             "p-value of the likelihood ratio against one slope for both sides, scaled to the error of the ratio"),
      result("loglik", &H::loglik, "Log-likelihood"),
      result("chi2", &H::chi2, "Pearson's test in bins of equal probability"),
      result("ndf", &H::ndf, "Its degrees of freedom"),
      result("p_value", &H::p_value, "Its p"),
      result("delta_aic_gaussian", &H::delta_aic_gaussian,
             "AIC(normal) - AIC(two exponentials); positive: the normal is worse"),
      result("bins", &H::bins, "`eps_edges`, `counts`, `underflow`, `overflow`"),
      result<H>(
          "curve", [](const H& h) { return as_columns(h.curve, "eps", "density"); },
          "`eps`, `density`: the fitted density with the timing errors"),
      result("shapes", &H::shapes, "Shapes fitted to the counts, see below"),
      result("verdict", &H::verdict, "In words")};
  return all;
}

const Description& members_of(const Bins*) {
  static const Description all{result("eps_edges", &Bins::eps_edges, "Edges of the bins"),
                               result("counts", &Bins::counts, "Samples in each"),
                               result("underflow", &Bins::underflow, "Samples below the first edge"),
                               result("overflow", &Bins::overflow, "Samples above the last edge")};
  return all;
}

const Description& members_of(const DensityPicture*) {
  using D = DensityPicture;
  static const Description all{
      result("v_edges_mps", &D::v_edges_mps, "Edges of the bins in speed"), result("eps_edges", &D::eps_edges, "In ε"),
      result("counts", &D::counts, "`counts[eps bin][v bin]`"), result("n_outside", &D::n_outside, "Samples outside")};
  return all;
}

const Description& members_of(const TimingNoise*) {
  using T = TimingNoise;
  static const Description all{
      result("n_pairs", &T::n_pairs, "Neighbouring samples"),
      result("lag1_correlation", &T::lag1_correlation, "Of their residuals: 0 asperities only, -2/3 timing only"),
      result("lag1_correlation_se", &T::lag1_correlation_se, "Its standard error"),
      result("variance_s2", &T::variance_s2, "Variance of a time that they show; negative by chance"),
      result("variance_se_s2", &T::variance_se_s2, "Its standard error"),
      result("sigma_s", &T::sigma_s, "Its root, where it is positive"),
      result("upper95_s", &T::upper95_s, "One-sided 95 % limit"),
      result("stated_s", &T::stated_s, "Median of what `sigma_eps` states")};
  return all;
}

const Description& members_of(const BudgetRow*) {
  using B = BudgetRow;
  static const Description all{
      result("v_mps", &B::v_mps, "Speed"),
      result("n", &B::n, "Samples"),
      result("spread", &B::spread, "Standard deviation of ε - ε(v)"),
      result("spread_asperities", &B::spread_asperities, "What the fit finds of the ball"),
      result("spread_timing_stated", &B::spread_timing_stated, "By `sigma_eps`"),
      result("spread_timing_lag1", &B::spread_timing_lag1, "By `timing`"),
      result("spread_travel_time", &B::spread_travel_time, "By the travel time of the sound"),
      result("share_asperities", &B::share_asperities, "Shares of the variance; their sum is 1"),
      result("share_timing", &B::share_timing, ""),
      result("share_travel_time", &B::share_travel_time, ""),
      result("share_unexplained", &B::share_unexplained, ""),
      result("shift_drag", &B::shift_drag,
             "Shift of ε by air drag, which is taken out; `null` where the ball is not known"),
      result("shift_contact_time", &B::shift_contact_time, "Likewise by the duration of contact"),
      result("mean_minus_peak", &B::mean_minus_peak, "What least squares would be off by"),
      result("se_curve", &B::se_curve, "Standard error of ε(v) here")};
  return all;
}

const Description& members_of(const ErrorBudget*) {
  using B = ErrorBudget;
  static const Description all{
      result("timing", &B::timing, "`null`, or the timing noise that neighbouring samples show, see below"),
      result("width_exponent", &B::width_exponent, "Estimate of k in spread ∝ v^k"),
      result<B>(
          "width_law", [](const B& b) { return as_columns(b.width_law, "v_mps", "spread"); },
          "`{v_mps, spread}` at both ends"),
      result<B>(
          "effects",
          [](const B& b) {
            Values all;
            for (const auto& [name, effect] : b.effects)
              all.push_back(Object{{"name", name}, {"state", std::string(to_string(effect))}});
            return all;
          },
          "`[{name, state}]`; `state` is `absent`, `not taken out` or `taken out`"),
      result<B>(
          "ball", [](const B& b) { return text_of_ball(b.ball); }, "That the shifts are for; `null`: not named"),
      result<B>(
          "plate", [](const B& b) { return text_of_ball(b.plate); }, "Likewise"),
      result("rows", &B::rows, "Bins of speed, see below")};
  return all;
}

}  // namespace bouncelab::fit
