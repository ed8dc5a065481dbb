// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of fits are called and what they are, key by key (docs/formats.md is made of these texts).
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::fit {
namespace {

/// `name` where the fit has a result, else not known.
template <class S, class Reach>
Member where_ok(std::string name, Reach reach, std::string text) {
  return result<S>(
      std::move(name),
      [reach](const S& s) { return s.status == FitStatus::ok ? value_of(std::invoke(reach, s)) : Value{}; },
      std::move(text));
}

/// The names of parameters, and each under its own.
template <class S>
Member estimates_by_name() {
  return result<S>(
      "",
      [](const S& s) {
        std::vector<std::string> names;
        Object all;
        for (const NamedEstimate& p : s.parameters) {
          names.push_back(p.name);
          all.emplace_back(p.name, value_of(p.estimate));
        }
        all.emplace_back("parameters", value_of(names));
        return all;
      },
      "`A2`, `A4`, `A5` ... or `gamma` or `eps`: an estimate each; `parameters`: their names, in the order of "
      "matrices");
}

Object by_name(const std::vector<NamedEstimate>& parameters) {
  Object all;
  for (const NamedEstimate& p : parameters) all.emplace_back(p.name, value_of(p.estimate));
  return all;
}

/// The points of a curve as two lists.
Object as_columns(const std::vector<CurvePoint>& curve, const std::string& x, const std::string& y) {
  std::vector<double> xs, ys;
  for (const CurvePoint& p : curve) {
    xs.push_back(p.x);
    ys.push_back(p.y);
  }
  return {{x, value_of(xs)}, {y, value_of(ys)}};
}

template <class Thing>
std::optional<std::string> text_of_ball(const std::optional<Thing>& ball) {
  if (!ball) return std::nullopt;
  if constexpr (std::is_same_v<Thing, Ball>)
    return to_text(*ball);
  else
    return plate_text(*ball);
}

Object tests_of(const MemoryFit& memory) { return object_of(members_of_tests(), &memory); }

Object roughness_of(const MemoryFit& memory) { return object_of(members_of_roughness(), &memory); }

Object pooled_law(const BetweenRecordings& between) {
  using B = BetweenRecordings;
  static const Description law{result("kind", &B::kind, "As of a law"), estimates_by_name<B>(),
                               result("correlation", &B::correlation, "As of a law"),
                               result("nodes", &B::nodes, "As of a law"),
                               result<B>(
                                   "curve",
                                   [](const B& b) {
                                     Values points;
                                     for (std::size_t k = 0; k < b.curve.size(); ++k) {
                                       Object point = object_of(members_of(&b.curve[k]), &b.curve[k]);
                                       point.emplace_back("prediction95", as_value(b.curve_prediction95[k]));
                                       points.push_back(std::move(point));
                                     }
                                     return points;
                                   },
                                   "As of a law, with the interval in which one more recording is expected")};
  return object_of(law, &between);
}

Value where_fitted(const MemoryFit& memory, Object (*of)(const MemoryFit&)) {
  return memory.status == FitStatus::ok ? Value(of(memory)) : Value{};
}

}  // namespace

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
      result<N>(
          "eps", [](const N& n) { return n.eps.value; }, "ε there, and its errors as of an estimate"),
      result<N>(
          "se", [](const N& n) { return n.eps.se; }, ""),
      result<N>(
          "se_independent", [](const N& n) { return n.eps.se_independent; }, ""),
      result<N>(
          "ci68", [](const N& n) { return n.eps.ci68; }, ""),
      result<N>(
          "ci95", [](const N& n) { return n.eps.ci95; }, ""),
      result<N>(
          "bootstrap", [](const N& n) { return n.eps.bootstrap; }, "")};
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
             "By default at 0.25, 0.6, 1.2 m/s where the "
             "data reach there, else within the data"),
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

const Description& members_of_tests() {
  using M = MemoryFit;
  static const Description all{
      result<M>(
          "leak_z", [](const M& m) { return m.leak.z; }, "No leak, in standard errors"),
      result<M>(
          "leak_p", [](const M& m) { return m.leak.p_value; }, "Its p, two-sided"),
      result<M>(
          "release_z", [](const M& m) { return m.release.z; },
          "No reservoir at the release, a statement on which nothing in the fit depends"),
      result<M>(
          "release_p", [](const M& m) { return m.release.p_value; }, "Its p, two-sided"),
      result<M>(
          "mechanism_z", [](const M& m) { return m.mechanism.z; }, "The scatter's offset and its width by the same q"),
      result<M>(
          "mechanism_p", [](const M& m) { return m.mechanism.p_value; }, "Its p, two-sided"),
      result<M>(
          "by_speed_z", [](const M& m) { return m.by_speed.z; },
          "The same q at every speed; above 0: faster impacts want more"),
      result<M>(
          "by_speed_p", [](const M& m) { return m.by_speed.p_value; }, "Its p, two-sided"),
      result<M>(
          "between_drops_ratio",
          [](const M& m) { return m.between_drops ? std::optional(m.between_drops->ratio) : std::nullopt; },
          "Variance between drops of what they ask of the parameters over what their impacts make it, 1 but for "
          "chance; `null` of one drop"),
      result<M>(
          "between_drops_p",
          [](const M& m) { return m.between_drops ? std::optional(m.between_drops->p_value) : std::nullopt; },
          "Its p, one-sided")};
  return all;
}

const Description& members_of_roughness() {
  using M = MemoryFit;
  static const Description all{
      result<M>(
          "q", [](const M& m) { return m.roughness.q.value; }, "c s₂, all that the scatter knows of ball and surface"),
      result<M>(
          "q_se", [](const M& m) { return m.roughness.q.se; }, "Its standard error"),
      result<M>(
          "q_ci95", [](const M& m) { return m.roughness.q.ci95; }, "Its 95 % interval"),
      result<M>(
          "ball", [](const M& m) { return text_of_ball(m.ball); },
          "That the following is for; `null` where none was named: a solid sphere"),
      result<M>(
          "inertia_factor", [](const M& m) { return m.roughness.inertia_factor; }, "Its J/(m R²)"),
      result<M>(
          "s2_no_slip", [](const M& m) { return m.roughness.s2_no_slip; },
          "s₂, variance of each component of the contact's offset over R, without slip: q (1 + J/(m R²))"),
      result<M>(
          "s2_frictionless", [](const M& m) { return m.roughness.s2_frictionless; },
          "The same without friction: q J/(m R²)"),
      result<M>(
          "rms_tilt_no_slip_deg", [](const M& m) { return m.roughness.rms_tilt_no_slip_deg; },
          "Root mean square angle of the contact's normal, √(2 s₂), in degrees"),
      result<M>(
          "n_constant_radii", [](const M& m) { return m.roughness.n_constant_radii; },
          "A surface with that `s2_no_slip`: number of asperities of one radius"),
      result<M>(
          "lambda_exponential", [](const M& m) { return m.roughness.lambda_exponential; },
          "Another: mean radius over R of exponential ones"),
      result<M>(
          "width_uniform_1e6", [](const M& m) { return m.roughness.width_uniform_1e6; },
          "Another: width over R of uniform ones, 1e6 of them"),
      result<M>("leak", leak_of, "As of the memory"),
      result<M>(
          "mechanism_p", [](const M& m) { return m.mechanism.p_value; }, "As of the memory")};
  return all;
}

const Description& members_of(const MemoryFit*) {
  using M = MemoryFit;
  static const Description all{
      result("status", &M::status,
             "`too_few_samples` below 60 impacts or where no drop has 10 successive ones; `not_converged`, also where "
             "the errors could not be found; `ok`"),
      result("message", &M::message, "What speaks against the model, empty where nothing does"),
      result("holds", &M::holds,
             "The model passes its tests (p above .01 for the transforms, `mechanism`, `by_speed` and "
             "`between_drops`) and is likelier than independent impacts. Where not: use `law`"),
      result("n", &M::n, "Impacts used"),
      result("n_drops", &M::n_drops, "Drops they are of"),
      result("n_chains", &M::n_chains, "Pieces of drops without a missing impact"),
      estimates_by_name<M>(),
      result("covariance", &M::covariance, "As of a law"),
      result("nodes", &M::nodes, "As of a law, at the same nodes"),
      result("node_correlation", &M::node_correlation, "As of a law"),
      where_ok<M>("leak", leak_of,
                  "Estimate of the share of the reservoir that is lost at each impact, long after the release; 0 "
                  "without tangential losses"),
      result("release_m2ps2", &M::release_m2ps2,
             "Estimate of the mean reservoir that the release left, always: that before the first impacts less what "
             "impacts before those add. Below 0 where the first fluctuations are smaller than those of a ball at rest"),
      where_ok<M>("loglik", &M::loglik, "Log-likelihood with memory"),
      result("loglik_independent", &M::loglik_independent, "Of the same impacts as independent ones"),
      result("anderson_darling", &M::anderson_darling,
             "Of the probability transforms of all impacts given the earlier ones: `null`, or `{a2, p_value, "
             "n_replicates}`"),
      result<M>(
          "transform_counts",
          [](const M& m) { return std::vector<double>(m.transform_counts.begin(), m.transform_counts.end()); },
          "Impacts by twentieths of the transform: equal, where the model holds"),
      where_ok<M>("tests", tests_of, "See below; `null` where `status` is not `ok`"),
      result("curve", &M::curve, "As of a law")};
  return all;
}

const Description& members_of(const RoughnessResult*) {
  using R = RoughnessResult;
  static const Description all{
      result<R>(
          "status", [](const R& r) { return r.memory.status; }, "As of the memory"),
      result<R>(
          "message", [](const R& r) { return r.memory.message; }, "As of the memory"),
      result<R>(
          "holds", [](const R& r) { return r.memory.holds; }, "As of the memory"),
      result<R>(
          "n", [](const R& r) { return r.memory.n; }, "Impacts used"),
      result<R>(
          "n_drops", [](const R& r) { return r.memory.n_drops; }, "Drops they are of"),
      result<R>(
          "n_chains", [](const R& r) { return r.memory.n_chains; }, "Pieces of drops without a missing impact"),
      result("n_left_out", &R::n_left_out, "Reason → number of samples left out"),
      result<R>(
          "roughness", [](const R& r) { return where_fitted(r.memory, roughness_of); }, "See [roughness](#roughness)"),
      result<R>(
          "tests", [](const R& r) { return where_fitted(r.memory, tests_of); }, "As of the memory"),
      result<R>(
          "anderson_darling", [](const R& r) { return r.memory.anderson_darling; }, "As of the memory")};
  return all;
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
      result("shift_drag", &B::shift_drag, "Shift of ε by air drag; `null` where the ball is not known"),
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

const Description& members_of(const Snippet*) {
  static const Description all{result("program", &Snippet::program, "Which code it is for"),
                               result("parameter", &Snippet::parameter, "Which of its parameters"),
                               result("text", &Snippet::text, "Lines to paste")};
  return all;
}

const Description& members_of(const DemExport*) {
  using D = DemExport;
  static const Description all{result("v_mps", &D::v_mps, "Speed of the simulated collisions"),
                               result("eps", &D::eps, "ε there"), result("se", &D::se, "Its standard error"),
                               result("warning", &D::warning, "How far ε moves over the speeds of the data"),
                               result("snippets", &D::snippets, "`[{program, parameter, text}]`")};
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

const Description& members_of(const FitResult*) {
  using F = FitResult;
  static const Description all{
      result("status", &F::status, "Of the main law"),
      result("n_used", &F::n_used, "Samples fitted"),
      result("n_left_out", &F::n_left_out, "Reason → number of samples left out"),
      result("law", &F::law, "The fit, see below"),
      result<F>(
          "recordings_test", [](const F& f) { return f.recordings.test; },
          "`null`, or the test whether recordings agree, see [several recordings](#several-recordings)"),
      result<F>(
          "recordings", [](const F& f) { return value_of(f.recordings.rows); },
          "`[...]`: a row for each recording, empty where there is one"),
      result("law_least_squares", &F::law_least_squares, "The same law by the mean"),
      result("law_least_absolute", &F::law_least_absolute, "The same law by the median"),
      result<F>(
          "law_comparison", [](const F& f) { return value_of(f.law.comparison); },
          "`[{name, n_parameters, loglik, aic, bic, delta_aic, delta_bic}]`, the law itself first, differences "
          "from the least of the list"),
      result("law_viscoelastic", &F::law_viscoelastic, "The one-parameter law (`gamma`)"),
      result("histograms", &F::histograms, "Windows of speed, see below"),
      result("budget", &F::budget, "Error budget, see below"),
      result("hand_off", &F::dem_export,
             "`null`, or `{v_mps, eps, se, warning, snippets: [{program, parameter, text}]}`: input lines for "
             "discrete-element codes"),
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
            if (f.memory) all.emplace_back("roughness", where_fitted(*f.memory, roughness_of));
            return all;
          },
          "`roughness`: likewise, see [roughness](#roughness)")};
  return all;
}

const Description& members_of(const StandardDeviation*) {
  static const Description all{result("value", &StandardDeviation::value, "Standard deviation"),
                               result("ci95", &StandardDeviation::ci95, "By profile likelihood")};
  return all;
}

const Description& members_of(const ChiSquareTest*) {
  static const Description all{result("chi2", &ChiSquareTest::chi2, "χ²"),
                               result("ndf", &ChiSquareTest::ndf, "Its degrees of freedom"),
                               result("p_value", &ChiSquareTest::p_value, "Its p")};
  return all;
}

const Description& members_of(const Drift*) {
  using D = Drift;
  static const Description all{result<D>(
                                   "per", [](const D& d) { return d.by_date ? "day" : "recording"; },
                                   "`day`; `recording` where fewer than half have a date: in their order"),
                               result("slope", &D::slope, "An estimate"),
                               result("p_value", &D::p_value, "p"),
                               result("begin", &D::begin, "Days since 1970-01-01, or the number of the recording"),
                               result("end", &D::end, "Likewise"),
                               result("middle", &D::middle, "Likewise; the pooled law belongs to it")};
  return all;
}

const Description& members_of(const GroupRow*) {
  static const Description all{result("name", &GroupRow::name, "The plate or the day"),
                               result("n", &GroupRow::n, "Recordings"),
                               result("offset", &GroupRow::offset, "Mean offset from the pooled law"),
                               result("se", &GroupRow::se, "Its standard error")};
  return all;
}

const Description& members_of(const Grouping*) {
  static const Description all{
      result("effect", &Grouping::effect,
             "`none` (`notes` say why), `fixed` (2 to 4 plates: a constant for each) or `random` (5 or more, and 5 "
             "recordings more than groups)"),
      result("deviation", &Grouping::deviation, "`null`, or as `tau`"),
      result("rows", &Grouping::rows, "`name`, `n`, `offset`, `se`")};
  return all;
}

const Description& members_of(const BetweenRecordings*) {
  using B = BetweenRecordings;
  static const Description all{
      result("notes", &B::notes, "What could not be had"),
      result("n_recordings", &B::n_recordings, "Recordings"),
      result("n_used", &B::n_used, "Those with a law of their own, outliers among them"),
      result("n_samples", &B::n_samples, "Their samples"),
      where_ok<B>("v_mps", &B::v_mps, "The reference speed"),
      where_ok<B>("eps", &B::eps,
                  "ε of the pooled law there, an estimate whose error includes what differs between recordings, in the "
                  "middle of the campaign"),
      where_ok<B>("prediction95", &B::prediction95, "Where one more recording is expected"),
      where_ok<B>("tau", &B::tau,
                  "`value`, `ci95`: standard deviation of ε between recordings, of one plate and day where these have "
                  "one, beyond the recordings' own errors; `ci95` by profile likelihood"),
      where_ok<B>("heterogeneity", &B::heterogeneity,
                  "`chi2`, `ndf`, `p_value`: whether the recordings (outliers too) differ at all"),
      where_ok<B>(
          "shapes", [](const B& b) { return b.shapes.ndf > 0.0 ? std::optional(b.shapes) : std::nullopt; },
          "The same: whether their curves differ by more than a constant (`null`: one speed)"),
      result("drift", &B::drift, "`null`, or ε over the campaign, see below"),
      where_ok<B>("law", pooled_law,
                  "`kind`, `parameters` and an estimate of each, `correlation`, `nodes`, `curve` as of a fit; `curve` "
                  "with `prediction95`"),
      result("plates", &B::plates, "Groups by plate, with the drift taken out"),
      result("days", &B::days, "Groups by day, with the plates taken out")};
  return all;
}

const Description& members_of(const RestitutionCounts*) {
  using C = RestitutionCounts;
  static const Description all{result("n_onsets", &C::n_onsets, "Impacts read"),
                               result("n_drops", &C::n_drops, "Drops"),
                               result("n_samples", &C::n_samples, "Coefficients of restitution"),
                               result("n_flagged", &C::n_flagged, "Of these with a flag: they stay out of the fit"),
                               result("eps_median", &C::eps_median, "Of the others"),
                               result<C>(
                                   "breaks",
                                   [](const C& c) {
                                     Object breaks;
                                     for (const auto& [reason, n] : c.breaks)
                                       breaks.emplace_back(name_of(reason), value_of(n));
                                     return breaks;
                                   },
                                   "Places where the chain of a drop is broken: reason → number")};
  return all;
}

const Description& members_of(const IntervalPrediction*) {
  using P = IntervalPrediction;
  static const Description all{result("impact", &P::impact, "That the interval follows"),
                               result("found_s", &P::measured_s, "As measured"),
                               result("expected_s", &P::predicted_s, "By the law; `null` without one"),
                               result("sigma_s", &P::sigma_s, "Standard error of the measured one")};
  return all;
}

const Description& members_of(const CalibrationRow*) {
  using R = CalibrationRow;
  static const Description all{
      result("name", &R::name, "The quantity"),
      result("truth", &R::truth, "Its true value"),
      result("bound_independent", &R::bound_independent, "Cramér-Rao bound of its error, if samples were independent"),
      result("spread", &R::spread, "Standard deviation of the estimates"),
      result("mean_se", &R::mean_se, "Mean of the standard errors stated"),
      result("pull_mean", &R::pull_mean, "Mean of (estimate - truth) / se"),
      result("pull_sd", &R::pull_sd, "Its standard deviation"),
      result("coverage68", &R::coverage68, "Share of the 68 % intervals that hold the truth"),
      result("coverage95", &R::coverage95, "Of the 95 % intervals")};
  return all;
}

const Description& members_of(const CalibrationResult*) {
  static const Description all{result("rows", &CalibrationResult::rows, "A row for each quantity"),
                               result("n_failed", &CalibrationResult::n_failed, "Seeds whose fit did not converge")};
  return all;
}

}  // namespace bouncelab::fit
