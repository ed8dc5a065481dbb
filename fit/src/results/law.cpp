// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of the law are called and what they are, key by key (docs/formats.md is made of these texts).
#include <utility>

#include "bouncelab/fit/fit.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

Value as_value(const Interval& interval) { return std::vector<double>{interval.lo, interval.hi}; }

Description members_of(const DropCount*) {
  static constexpr Member all[]{
      member<&DropCount::n>("n", "Number of drops"),
      member<&DropCount::errors>(
          "errors",
          "`by_drop` (from 10 drops on), `by_sample` (from 30 samples a parameter on) or `independent_samples`")};
  return all;
}

Description members_of(const Estimate*) {
  using E = Estimate;
  static constexpr Member all[]{
      member<&E::value>("value", "Value"),
      member<&E::se>("se", "Standard error: by drop or of independent samples, as the fit's `drops` says"),
      member<&E::se_independent>(
          "se_independent",
          "Where `se` is by drop or by sample: from the expected Fisher information, if samples were independent")
          .left_out_where_unknown(),
      member<&E::ci95>("ci95", "`[lo, hi]`, 95 % confidence interval, of the same kind as `se`"),
      computed(
          "identified", [](const E& e) { return e.identified ? std::nullopt : std::optional(false); },
          "`false` where these data do not determine it, else not there")
          .left_out_where_unknown()};
  return all;
}

Description members_of(const NodeEstimate*) {
  using N = NodeEstimate;
  static constexpr Member all[]{member<&N::v_mps>("v_mps", "Speed"),
                                member<&N::eps, &Estimate::value>("eps", "ε there"),
                                member<&N::eps, &Estimate::se>("se", "Its standard error, as of an estimate"),
                                member<&N::eps, &Estimate::ci95>("ci95", "95 % confidence interval of ε")};
  return all;
}

Description members_of(const CurveNode*) {
  using N = CurveNode;
  static constexpr Member all[]{
      member<&N::v_mps>("v_mps", "Speed"),
      member<&N::eps, &Estimate::value>("eps", "ε there, root mean square: √⟨ε²⟩"),
      member<&N::eps, &Estimate::se>("se", "Its standard error"),
      member<&N::eps, &Estimate::ci95>("ci95", "Its 95 % interval"),
      member<&N::mean, &Estimate::value>("mean", "⟨ε⟩ there"),
      member<&N::mean, &Estimate::se>("mean_se", "Its standard error"),
      computed(
          "peak", [](const N& n) { return n.peak ? std::optional(n.peak->value) : std::nullopt; },
          "The most frequent ε; `null` where the density of the scatter was not fitted"),
      computed(
          "peak_se", [](const N& n) { return n.peak ? n.peak->se : std::nullopt; }, "Its standard error")};
  return all;
}

Description members_of(const CurvePoint*) {
  using P = CurvePoint;
  static constexpr Member all[]{
      member<&P::x>("v_mps", "Speed"), member<&P::y>("eps", "ε there"),
      computed(
          "lo95", [](const P& p) { return p.band95 ? std::optional(p.band95->lo) : std::nullopt; },
          "Lower end of its 95 % interval"),
      computed(
          "hi95", [](const P& p) { return p.band95 ? std::optional(p.band95->hi) : std::nullopt; }, "Upper end")};
  return all;
}

Description members_of(const AndersonDarling*) {
  using A = AndersonDarling;
  static constexpr Member all[]{member<&A::a2>("a2", "A²"),
                                member<&A::p_value>("p_value", "p, by refitting samples drawn from the fit"),
                                member<&A::n_replicates>("n_replicates", "How many")};
  return all;
}

Description members_of(const ScatterModel*) {
  using S = ScatterModel;
  static constexpr Member all[]{
      member<&S::v_ref_mps>("v_ref_mps", "v_ref"),
      member<&S::log_below>("log_below", "c_k of b below the peak, the rising side"),
      member<&S::log_above>("log_above", "c_k of b above it, the falling side"),
      member<&S::normal_ratio>("normal_ratio", "Standard deviation of the normal part over √(b₋ b₊), 0 without one")};
  return all;
}

Description members_of(const ResidualBin*) {
  using B = ResidualBin;
  static constexpr Member all[]{
      member<&B::v_mps>("v_mps", "Median speed"),
      member<&B::n>("n", "Samples"),
      member<&B::mean_residual>("mean_residual", "Mean of ε less the law"),
      member<&B::median_residual>("median_residual", "Its median"),
      member<&B::pull>("pull", "Mean score of the location over its standard error"),
      member<&B::scatter_ratio>("scatter_ratio", "Mean absolute residual over what is expected")};
  return all;
}

namespace {

/// Each reason once, whichever codes have it.
std::string reasons_of(const DemExport& dem) {
  std::string text, last;
  for (const MissingModel& missing : dem.missing)
    if (missing.reason != std::exchange(last, missing.reason)) text += (text.empty() ? "" : "; ") + missing.reason;
  return text;
}

}  // namespace

Description members_of(const DemExport*) {
  using D = DemExport;
  static constexpr Member all[]{
      member<&D::v_mps>("v_mps", "Speed of the simulated collisions"),
      member<&D::eps>("eps", "√⟨ε²⟩ there, root mean square"),
      member<&D::se>("se", "Its standard error"),
      member<&D::gamma>("gamma",
                        "γ of the viscoelastic sphere with that ε there; `null` where it does not fit "
                        "at other speeds"),
      member<&D::ball>("ball", "Ball and plate whose contact the inputs have"),
      member<&D::warning>("warning", "How far ε moves over the speeds of the data"),
      computed(
          "missing", [](const D& d) { return reasons_of(d); },
          "Which models the codes do not get, and why; why `gamma` is `null`")};
  return all;
}

Description members_of(const RecordingsTest*) {
  using T = RecordingsTest;
  static constexpr Member all[]{
      member<&T::n_recordings>("n_recordings", "Compared: those of three samples or more"),
      member<&T::likelihood_ratio>("likelihood_ratio", "2 Δ log L"),
      member<&T::f>("f", "F; exact for normal scatter, also with few samples"),
      member<&T::ndf>("ndf", "Its degrees of freedom"),
      member<&T::ndf_within>("ndf_within", "Likewise"),
      member<&T::within>(
          "within",
          "What the differences are measured by: `drops`, the differences between drops of a recording, where these "
          "have 10 degrees of freedom; else `samples`, as if all impacts were independent; `recordings`, those between "
          "the recordings of a plate, where these differ by more than chance"),
      member<&T::p_value>("p_value", "p")};
  return all;
}

Description members_of(const RecordingFit*) {
  using R = RecordingFit;
  static constexpr Member all[]{
      member<&R::recording>("recording", "Its name"),
      member<&R::law, &LawFit::status>("status", "How its fit ended"),
      member<&R::law, &LawFit::kind>("law", "`series`, `viscoelastic` or `constant`"),
      member<&R::law, &LawFit::n>("n", "Samples fitted"),
      computed(
          "n_outliers", [](const R& r) { return r.law.outliers.size(); }, "Samples left out as lost bounces"),
      member<&R::n_drops>("n_drops", "Its drops"),
      member<&R::v_lo_mps>("v_lo_mps", "Its speeds"),
      member<&R::v_hi_mps>("v_hi_mps", "Likewise"),
      member<&R::offset>(
          "offset",
          "`null`, or an estimate of how far its ε is off the common curve, the mean over all samples being 0 (its "
          "standard error takes curve, scatter and independence as given)"),
      member<&R::nodes>(
          "nodes",
          "ε of its own curve, as `nodes` of the curve of all: at those of them that lie within this recording's "
          "speeds, else at its median speed"),
      computed(
          "slopes",
          [](const R& r) {
            Values slopes;
            for (const HistogramFit& h : r.histograms)
              if (h.peak_eps) slopes.emplace_back(object_of(slopes_of(&h), &h));
            return slopes;
          },
          "Window by window, from `v_lo_mps` to `slope_ratio` as `histograms`: p(ε) of its samples in the windows of "
          "speed that have enough, as `histograms`; empty of more than 100 recordings"),
      member<&R::with_memory>("with_memory", "Constants by the fit with memory; of plates alone"),
      estimates_by_name<&R::parameters>()};
  return all;
}

Description members_of(const Curve*) {
  using C = Curve;
  static constexpr Member all[]{
      member<&C::nodes>(
          "nodes",
          "`[{v_mps, eps, se, ci95, mean, mean_se, peak, peak_se}]`, by default at the speeds below which "
          "10, 50 and 90 % of the samples lie, to two digits"),
      member<&C::covariance>("covariance", "Of the mean of ε at the nodes, matrix by rows"),
      member<&C::points>("points",
                         "`[{v_mps, eps, lo95, hi95}]` from the slowest bounce to the fastest; empty of one speed "
                         "alone"),
      member<&C::end_changes>("end_changes", "Difference of ε at the first and the last point from the middle node"),
      member<&C::scatter>("scatter", "Standard deviation of ε from bounce to bounce, at the median speed"),
      member<&C::scatter_of_drops>("scatter_of_drops",
                                   "Standard deviation of what the bounces of a drop share; `null` of one drop"),
      member<&C::errors_over_digits>(
          "errors_over_digits",
          "Standard errors of times, heights or speeds over those of their digits, as the fit "
          "finds them; not there where they are stated")
          .left_out_where_unknown(),
      member<&C::n_drops>("n_drops", "Drops; of one the curve is that of this drop"),
      member<&C::kappa_per_m>("kappa_per_m", "Drag over speed squared at 1 m/s [1/m]; `null`: none"),
      member<&C::contact_s>("contact_s", "Contact time at 1 m/s; `null`: none"),
      member<&C::kappa_pull>("kappa_pull",
                             "Of a named ball: how far its drag is from what such a ball has, in standard deviations")
          .left_out_where_unknown(),
      member<&C::contact_pull>("contact_pull", "Likewise its contact time").left_out_where_unknown(),
      member<&C::share_of_drag>("share_of_drag", "Part of the variance of ε at the middle node that drag leaves"),
      member<&C::share_of_contact>("share_of_contact", "Likewise by contact time"),
      member<&C::step>("step", "`{v_mps, eps_faster, eps_slower, change, impact}` where ε changes at once; or `null`"),
      member<&C::rebound>("rebound",
                          "What a ball of a sport that is named would rebound in the test of its rules, where the "
                          "speed of that test lies within those of the samples or a twentieth beside them, see below; "
                          "else not there")
          .left_out_where_unknown()};
  return all;
}

std::optional<bool> Rebound::is_within() const {
  if (height_m.ci95->lo >= rule.least_m && height_m.ci95->hi <= rule.most_m) return true;
  if (height_m.ci95->hi < rule.least_m || height_m.ci95->lo > rule.most_m) return false;
  return std::nullopt;
}

Description members_of(const Rebound*) {
  using R = Rebound;
  static constexpr Member all[]{
      member<&R::rule>("rule", "`{by, height_m, least_m, most_m, floor, source}`, as `bouncelab balls --json` has it"),
      member<&R::v_mps>("v_mps", "Speed of the impact, by the drag that such a ball has"),
      member<&R::height_m, &Estimate::value>("rebound_m", "What it rebounds, by the root mean square of ε there"),
      member<&R::height_m, &Estimate::se>("se", "Its standard error"),
      member<&R::height_m, &Estimate::ci95>("ci95", "Its 95 % interval"),
      member<&R::is_within>("within", "Whether the interval lies within the rule; `null`: it reaches across a limit")};
  return all;
}

Description members_of(const LawMisfit*) {
  using M = LawMisfit;
  static constexpr Member all[]{
      member<&M::ln_bayes_factor>("ln_bayes_factor",
                                  "ln of the Bayes factor of the law with a smooth deviation over the law alone; above "
                                  "3 the law does not describe the samples"),
      member<&M::v_mps>("v_mps", "Where the deviation is largest for its error"),
      member<&M::off>("off", "The curve less the law there")};
  return all;
}

Description members_of(const Constants*) {
  using C = Constants;
  static constexpr Member all[]{
      member<&C::status>("status", "How their fit ended; `not_applicable` where the law does not describe the samples"),
      member<&C::with_memory>("with_memory", "By the fit with memory; else impacts are taken as independent"),
      estimates_by_name<&C::parameters>(), member<&C::covariance>("covariance", "Matrix by rows"),
      member<&C::gamma>("gamma",
                        "γ of a viscoelastic sphere, an estimate, impacts taken as independent; `null` where none "
                        "describes the samples")};
  return all;
}

Description members_of(const RestitutionStep*) {
  using S = RestitutionStep;
  static constexpr Member all[]{member<&S::v_mps>("v_mps", "Speed"),
                                member<&S::eps_faster>("eps_faster", "ε of those just faster"),
                                member<&S::eps_slower>("eps_slower", "ε of those just slower"),
                                member<&S::change>("change", "Difference of the two, an estimate"),
                                member<&S::impact>("impact", "Number of the last faster one, of one drop")};
  return all;
}

Description members_of(const KindsOfDrops*) {
  using K = KindsOfDrops;
  static constexpr Member all[]{member<&K::n_lower>("n_lower", "Drops of the lower kind"),
                                member<&K::n_upper>("n_upper", "Of the upper"),
                                member<&K::eps_lower>("eps_lower", "Median of ε of the lower"),
                                member<&K::eps_upper>("eps_upper", "Of the upper")};
  return all;
}

namespace {

/// How well the density that the fit assumes describes the scatter.
Object goodness_of(const FitResult& result) {
  const LawFit& law = result.law;
  Object goodness;
  if (law.pearson) goodness = object_of(*law.pearson);
  if (law.anderson_darling) goodness.emplace_back("anderson_darling", value_of(*law.anderson_darling));
  return goodness;
}

/// One bin alone has nothing to be compared with.
std::vector<ResidualBin> residuals_of(const FitResult& result) {
  return result.law.residuals.size() > 1 ? result.law.residuals : std::vector<ResidualBin>{};
}

std::vector<HistogramFit> fitted_windows(const FitResult& result) {
  std::vector<HistogramFit> fitted;
  for (const HistogramFit& window : result.histograms)
    if (window.peak_eps) fitted.push_back(window);
  return fitted;
}

}  // namespace

Description members_of(const FitResult*) {
  using F = FitResult;
  static constexpr Member all[]{
      member<&F::n_used>("n_used", "Samples fitted"),
      member<&F::n_left_out>("n_left_out", "Reason → number of samples left out"),
      member<&F::curve>("curve", "ε(v), the answer, see below"),
      member<&F::constants>("constants", "Constants of the law as they are stated, see below"),
      member<&F::law, &LawFit::misfit>(
          "misfit", "`null`, or how the law compares with the smooth curve: `{ln_bayes_factor, v_mps, off}`"),
      member<&F::law, &LawFit::drops>("drops", "Their number, and what `se` and intervals of constants rest on"),
      member<&F::law, &LawFit::scatter>("scatter", "Of the samples about the peak, see below"),
      member<goodness_of>(
          "goodness",
          "`{chi2, ndf, p_value, anderson_darling}`: is the scatter as the fit assumes? Pearson's test from five "
          "degrees of freedom on, and `{a2, p_value, n_replicates}`; each where it was made"),
      member<residuals_of>("residuals", "Bins of speed, see below; from two on"),
      member<&F::recordings, &Recordings::test>(
          "recordings_test",
          "The test whether recordings agree, see [several recordings](#several-recordings); not there of one")
          .left_out_where_unknown(),
      computed(
          "recordings_are",
          [](const F& f) { return !f.recordings.plates.empty() ? std::optional<std::string>("plates") : std::nullopt; },
          "`plates` with `--groups`: what is called a recording is then all recordings of a plate; else not there")
          .left_out_where_unknown(),
      member<&F::recordings, &Recordings::rows>("recordings",
                                                "`[...]`: a row for each recording, empty where there is one"),
      member<&F::kinds_of_drops>(
          "kinds_of_drops", "Where drops are of two kinds `{n_lower, n_upper, eps_lower, eps_upper}`, else not there")
          .left_out_where_unknown(),
      member<&F::is_one_ball>(
          "is_one_ball",
          "Recordings and drops are seen to agree, or `--pool` was given; else `answer` and `hand_off` have no value "
          "for all"),
      member<fitted_windows>("histograms", "Windows of speed that have enough samples, see below"),
      member<&F::budget>("budget", "Error budget, see below"),
      member<&F::dem_export>(
          "hand_off",
          "`null`, or `{v_mps, eps, se, gamma, ball, warning, missing}`: ε at one speed for codes that "
          "take one; `dem` makes its inputs of `curve`, `scatter` and `constants`, at this speed"),
      member<&F::density>("density",
                          "Counts of samples, of more than 400 (fewer are shown one by one): `v_edges_mps`, "
                          "`eps_edges`, `counts[eps bin][v bin]`, `n_outside`"),
      member<&F::memory>(
          "memory",
          "With `--method memory`, and by default (`auto`) from 5 drops of 30 impacts on average on, see "
          "[memory](#memory)")
          .left_out_where_unknown(),
      computed(
          "",
          [](const F& f) {
            Object roughness;
            if (f.memory) roughness.emplace_back("roughness", roughness_if_fitted(*f.memory));
            return roughness;
          },
          "`roughness`: likewise, see [roughness](#roughness)")};
  return all;
}

}  // namespace bouncelab::fit
