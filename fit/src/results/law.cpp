// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of the law are called and what they are, key by key (docs/formats.md is made of these texts).
#include "bouncelab/fit/fit.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

Value as_value(const Interval& interval) { return std::vector<double>{interval.lo, interval.hi}; }

const Description& members_of(const BootstrapErrors*) {
  using B = BootstrapErrors;
  static const Description all{
      result("se", &B::se, "Standard deviation of the replicates"), result("ci68", &B::ci68, "Their percentiles"),
      result("ci95", &B::ci95, "Their percentiles"), result("n_replicates", &B::n_replicates, "How many")};
  return all;
}

const Description& members_of(const DropCount*) {
  static const Description all{
      result("n", &DropCount::n, "Number of drops"),
      result("errors", &DropCount::errors,
             "`by_drop` (from 10 drops on), `by_sample` (from 30 samples a parameter on) or `independent_samples`")};
  return all;
}

const Description& members_of(const Estimate*) {
  using E = Estimate;
  static const Description all{
      result("value", &E::value, "Value"),
      result("se", &E::se, "Standard error: by drop or of independent samples, as the fit's `drops` says"),
      result("se_independent", &E::se_independent,
             "Where `se` is by drop or by sample: from the expected Fisher information, if samples were independent; "
             "else `null`"),
      result("ci68", &E::ci68, "`[lo, hi]`, 68.27 % confidence interval, of the same kind as `se`"),
      result("ci95", &E::ci95, "95 % confidence interval"),
      result<E>(
          "intervals", [](const E& e) { return e.interval_method ? to_string(*e.interval_method) : ""; },
          "How they were made: `profile` or `covariance`"),
      result("bootstrap", &E::bootstrap, "`null`, or `{se, ci68, ci95, n_replicates}` by drop (`--bootstrap`)"),
      result("identified", &E::identified, "`false`: these data do not determine it")};
  return all;
}

const Description& members_of(const NodeEstimate*) {
  using N = NodeEstimate;
  static const Description all{
      result("v_mps", &N::v_mps, "Speed"),
      result("eps", path(&N::eps, &Estimate::value), "ε there, and its errors as of an estimate"),
      result("se", path(&N::eps, &Estimate::se), ""),
      result("se_independent", path(&N::eps, &Estimate::se_independent), ""),
      result("ci68", path(&N::eps, &Estimate::ci68), ""),
      result("ci95", path(&N::eps, &Estimate::ci95), ""),
      result("bootstrap", path(&N::eps, &Estimate::bootstrap), "")};
  return all;
}

const Description& members_of(const CurvePoint*) {
  using P = CurvePoint;
  static const Description all{
      result("v_mps", &P::x, "Speed"), result("eps", &P::y, "ε there"),
      result<P>(
          "lo95", [](const P& p) { return p.band95 ? std::optional(p.band95->lo) : std::nullopt; },
          "Lower end of its 95 % interval"),
      result<P>(
          "hi95", [](const P& p) { return p.band95 ? std::optional(p.band95->hi) : std::nullopt; }, "Upper end")};
  return all;
}

const Description& members_of(const AndersonDarling*) {
  using A = AndersonDarling;
  static const Description all{result("a2", &A::a2, "A²"),
                               result("p_value", &A::p_value, "p, by refitting samples drawn from the fit"),
                               result("n_replicates", &A::n_replicates, "How many")};
  return all;
}

const Description& members_of(const ScatterModel*) {
  using S = ScatterModel;
  static const Description all{
      result<S>(
          "form",
          [](const S&) {
            return "log b = sum_k c_k log(v/v_ref)^k, b the means of two exponentials; convolved with a normal of "
                   "normal_ratio sqrt(b_below b_above)";
          },
          "The formula: two exponentials and a normal part; ε(v) is the peak of the sum"),
      result("v_ref_mps", &S::v_ref_mps, "v_ref"),
      result("log_below", &S::log_below, "c_k of b below the peak, the rising side"),
      result("log_above", &S::log_above, "c_k of b above it, the falling side"),
      result("normal_ratio", &S::normal_ratio, "Standard deviation of the normal part over √(b₋ b₊), 0 without one")};
  return all;
}

const Description& members_of(const ResidualBin*) {
  using B = ResidualBin;
  static const Description all{
      result("v_mps", &B::v_mps, "Median speed"),
      result("n", &B::n, "Samples"),
      result("mean_residual", &B::mean_residual, "Mean of ε - ε(v)"),
      result("median_residual", &B::median_residual, "Its median"),
      result("pull", &B::pull, "Mean score of the location over its standard error"),
      result("scatter_ratio", &B::scatter_ratio, "Mean absolute residual over what is expected")};
  return all;
}

const Description& members_of(const LawComparison*) {
  using C = LawComparison;
  static const Description all{result("name", &C::name, "The law's constants"),
                               result("n_parameters", &C::n_parameters, "Of law and scatter"),
                               result("loglik", &C::loglik, "Log-likelihood"),
                               result("aic", &C::aic, "AIC"),
                               result("bic", &C::bic, "BIC"),
                               result("delta_aic", &C::delta_aic, "AIC less the least of the list"),
                               result("delta_bic", &C::delta_bic, "Likewise")};
  return all;
}

const Description& members_of(const LawFit*) {
  using F = LawFit;
  static const Description all{
      result("status", &F::status, "How the fit ended"),
      result("message", &F::message, "In words, empty where all is well"),
      result("law", &F::kind, "`series`, `viscoelastic` or `constant`"),
      result("method", &F::method, "`asymmetric_laplace`, `least_squares` or `least_absolute`"),
      result("n", &F::n, "Samples"),
      result("drops", &F::drops, "Their number, and what `se`, intervals and covariances rest on"),
      result<F>(
          "n_outliers", [](const F& f) { return f.outliers.size(); },
          "Samples left out as lost bounces (more likely than scatter)"),
      result("n_parameters", &F::n_parameters, "Of law and scatter"),
      estimates_by_name<F>(),
      result("correlation", &F::correlation, "Matrix by rows"),
      result("covariance", &F::covariance, "Matrix by rows"),
      result("condition_number", &F::condition_number, "Of the correlation matrix"),
      result("nodes", &F::nodes,
             "By default at the speeds below which 10, 50 and 90 % of the samples lie, to two digits"),
      result("node_correlation", &F::node_correlation, "Matrix by rows"),
      result("scatter", &F::scatter, "Of the samples about ε(v), see below"),
      result("loglik", &F::loglik, "Log-likelihood"),
      result("aic", &F::aic, "AIC"),
      result("bic", &F::bic, "BIC"),
      result("chi2", &F::chi2, "Pearson's test of the probability transforms"),
      result("ndf", &F::ndf, "Its degrees of freedom"),
      result("p_value", &F::p_value, "Its p"),
      result("anderson_darling", &F::anderson_darling, "`null`, or `{a2, p_value, n_replicates}`"),
      result("curve", &F::curve, "`[{v_mps, eps, lo95, hi95}]`"),
      result("residuals", &F::residuals, "Bins of speed, see below")};
  return all;
}

const Description& members_of(const Snippet*) {
  static const Description all{result("program", &Snippet::program, "Which code it is for"),
                               result("model", &Snippet::model, "`constant`, `viscoelastic`; `fluctuating`, `memory`"),
                               result("parameter", &Snippet::parameter, "Which of its parameters"),
                               result("text", &Snippet::text, "A whole input, or a function")};
  return all;
}

const Description& members_of(const DemExport*) {
  using D = DemExport;
  static const Description all{
      result("v_mps", &D::v_mps, "Speed of the simulated collisions"),
      result("eps", &D::eps, "√⟨ε²⟩ there, root mean square"),
      result("se", &D::se, "Standard error, that of the peak"),
      result("mean", &D::mean, "⟨ε⟩ there"),
      result("peak", &D::peak, "Peak of p(ε) there"),
      result("gamma", &D::gamma,
             "γ of the viscoelastic sphere with that ε there; `null` where it does not fit "
             "at other speeds"),
      result("ball", &D::ball, "Ball and plate whose contact the inputs have"),
      result("warning", &D::warning, "How far ε moves over the speeds of the data; why `gamma` is `null`"),
      result("snippets", &D::snippets, "`[{program, model, parameter, text}]`")};
  return all;
}

const Description& members_of(const RecordingsTest*) {
  using T = RecordingsTest;
  static const Description all{
      result("n_recordings", &T::n_recordings, "Compared: those of three samples or more"),
      result("likelihood_ratio", &T::likelihood_ratio, "2 Δ log L"),
      result("f", &T::f, "F; exact for normal scatter, also with few samples"),
      result("ndf", &T::ndf, "Its degrees of freedom"),
      result("ndf_within", &T::ndf_within, "Likewise"),
      result("within", &T::within,
             "What the differences are measured by: `drops`, the differences between drops of a recording, where these "
             "have 10 degrees of freedom; else `samples`, as if all impacts were independent"),
      result("p_value", &T::p_value, "p")};
  return all;
}

const Description& members_of(const RecordingFit*) {
  using R = RecordingFit;
  static const Description all{
      result("recording", &R::recording, "Its name"),
      result("status", &R::status, "How its fit ended"),
      result("message", &R::message, "In words, empty where all is well"),
      result("law", &R::kind, "As of a law"),
      result("n", &R::n, "Samples fitted"),
      result("n_outliers", &R::n_outliers, "As of a law"),
      result("n_drops", &R::n_drops, "Its drops"),
      result("v_lo_mps", &R::v_lo_mps, "Its speeds"),
      result("v_hi_mps", &R::v_hi_mps, "Likewise"),
      result("offset", &R::offset,
             "`null`, or an estimate of how far its ε is off the common curve, the mean over all samples being 0 (its "
             "standard error takes curve, scatter and independence as given)"),
      result("nodes", &R::nodes,
             "As of a law: at the nodes of the pooled law that lie within this recording's speeds, else at its median "
             "speed"),
      estimates_by_name<R>()};
  return all;
}

const Description& members_of(const AveragedCurve*) {
  using A = AveragedCurve;
  static const Description all{
      result("nodes", &A::nodes, "ε at each node: an estimate with `v_mps`"),
      result("changes", &A::changes, "Difference of ε at each node from that at the middle one"),
      result("curve", &A::curve, "As that of the law; empty of one speed alone"),
      result("laws", &A::laws,
             "The laws by their constants → weight, the largest first; `(yields)`: falling as what yields does"),
      result("kappa_per_m", &A::kappa_per_m, "Drag over speed squared at 1 m/s [1/m]; `null`: none"),
      result("contact_s", &A::contact_s, "Contact time at 1 m/s; `null`: none"),
      result("share_of_drag", &A::share_of_drag, "Part of the variance of ε at the middle node that drag leaves"),
      result("share_of_contact", &A::share_of_contact, "Likewise by contact time"),
      result("step", &A::step,
             "`{v_mps, eps_faster, eps_slower, impact}` where ε(v) nearly certainly has one; or `null`")};
  return all;
}

const Description& members_of(const RestitutionStep*) {
  using S = RestitutionStep;
  static const Description all{result("v_mps", &S::v_mps, "Speed"),
                               result("eps_faster", &S::eps_faster, "ε of those just faster"),
                               result("eps_slower", &S::eps_slower, "ε of those just slower"),
                               result("impact", &S::impact, "Number of the last faster one, of one drop")};
  return all;
}

const Description& members_of(const KindsOfDrops*) {
  using K = KindsOfDrops;
  static const Description all{result("n_lower", &K::n_lower, "Drops of the lower kind"),
                               result("n_upper", &K::n_upper, "Of the upper"),
                               result("eps_lower", &K::eps_lower, "Median of ε of the lower"),
                               result("eps_upper", &K::eps_upper, "Of the upper")};
  return all;
}

const Description& members_of(const FitResult*) {
  using F = FitResult;
  static const Description all{
      result("status", &F::status, "Of the law that is quoted: with memory where that holds, else `law`"),
      result("n_used", &F::n_used, "Samples fitted"),
      result("n_left_out", &F::n_left_out, "Reason → number of samples left out"),
      result(
          "law", &F::law,
          "The fit that takes impacts as independent, see below; where `memory` holds, a comparison: its constants and "
          "curve are then the result"),
      result("averaged", &F::averaged,
             "ε over several laws, drag and contact time, as `answer` has it: `nodes`, `changes`, `curve`, `laws`, "
             "`kappa_per_m`, "
             "`contact_s`, `share_of_drag`, `share_of_contact`, `step`; `null` of very many samples that hold neither"),
      result("recordings_test", path(&F::recordings, &Recordings::test),
             "`null`, or the test whether recordings agree, see [several recordings](#several-recordings)"),
      result("recordings", path(&F::recordings, &Recordings::rows),
             "`[...]`: a row for each recording, empty where there is one"),
      result("kinds_of_drops", &F::kinds_of_drops,
             "`null`, or where drops are of two kinds `{n_lower, n_upper, eps_lower, eps_upper}`"),
      result(
          "is_one_ball", &F::is_one_ball,
          "Recordings and drops are seen to agree, or `--pool` was given; else `answer` and `hand_off` have no value "
          "for all"),
      result("law_least_squares", &F::law_least_squares, "The same law by the mean"),
      result("law_least_absolute", &F::law_least_absolute, "The same law by the median"),
      result("law_comparison", path(&F::law, &LawFit::comparison),
             "`[{name, n_parameters, loglik, aic, bic, delta_aic, delta_bic}]`, the law itself first, differences "
             "from the least of the list"),
      result("law_viscoelastic", &F::law_viscoelastic, "The one-parameter law (`gamma`)"),
      result("histograms", &F::histograms, "Windows of speed, see below"),
      result("budget", &F::budget, "Error budget, see below"),
      result("hand_off", &F::dem_export,
             "`null`, or `{v_mps, eps, se, mean, peak, gamma, ball, warning, snippets: [{program, model, parameter, "
             "text}]}`: inputs of discrete-element codes, which `dem` prints"),
      result("density", &F::density,
             "Counts of samples: `v_edges_mps`, `eps_edges`, `counts[eps bin][v bin]`, `n_outside`"),
      result("memory", &F::memory,
             "With `--method memory`, and by default (`auto`) from 5 drops of 30 impacts on average on, see "
             "[memory](#memory); then `law` is by `asymmetric_laplace`")
          .left_out_where_unknown(),
      result<F>(
          "",
          [](const F& f) {
            Object all;
            if (f.memory) all.emplace_back("roughness", roughness_if_fitted(*f.memory));
            return all;
          },
          "`roughness`: likewise, see [roughness](#roughness)")};
  return all;
}

}  // namespace bouncelab::fit
