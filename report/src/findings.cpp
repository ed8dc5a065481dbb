// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "words.hpp"

namespace bouncelab::report {
using namespace fit;

namespace {

std::string joined(const std::vector<std::string>& parts, const char* separator = ", ") {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : separator) + part;
  return text;
}

std::string sentence(std::string text) {
  if (text.front() >= 'a' && text.front() <= 'z') text.front() = static_cast<char>(text.front() - 'a' + 'A');
  return text + ".";
}

std::string describe_nodes(const Curve& curve) {
  std::vector<std::string> nodes;
  for (const CurveNode& node : curve.nodes)
    nodes.push_back(fit::in_words(node.eps.value, node.eps.se) + formatted(" at %.3g m/s", node.v_mps));
  return joined(nodes);
}

std::string describe_constants(const std::vector<NamedEstimate>& parameters) {
  std::vector<std::string> known;
  for (const NamedEstimate& p : parameters)
    if (p.estimate.identified) known.push_back(p.name + " = " + fit::in_words(p.estimate.value, p.estimate.se));
  return joined(known);
}

/// Mean and peak where they are another than the root mean square by more than its error.
std::string other_centres(const Curve& curve) {
  const CurveNode& middle = curve.nodes[curve.nodes.size() / 2];
  std::vector<std::string> others;
  const auto add = [&](const char* name, const Estimate& other) {
    if (std::abs(other.value - middle.eps.value) > middle.eps.se.value_or(0.0))
      others.push_back(name + fit::in_words(other.value, other.se));
  };
  add("the mean is ", middle.mean);
  if (middle.peak) add("the most frequent ε is ", *middle.peak);
  return others.empty() ? ""
                        : formatted(" At %.3g m/s ", middle.v_mps) + joined(others, " and ") +
                              ": ε here is the root mean square, which keeps the energy.";
}

std::string dependence(const FitResult& r) {
  const std::string constants = constants_in_words(r);
  return "ε = " + describe_nodes(*r.curve) + " (± one standard error)." + other_centres(*r.curve) +
         (constants.empty() ? "" : " ") + constants;
}

}  // namespace

std::string constants_in_words(const FitResult& r) {
  std::vector<std::string> unknown;
  for (const NamedEstimate& p : r.constants.parameters)
    if (!p.estimate.identified) unknown.push_back(p.name);
  const std::string known = describe_constants(r.constants.parameters);
  std::string text;
  if (!known.empty())
    text = " Constants of the law: " + known + (r.constants.with_memory ? " (by the fit with memory)." : ".");
  if (r.constants.status == FitStatus::not_applicable && r.constants.why) text += " " + as_sentence(*r.constants.why);
  if (r.constants.gamma)
    text += " As a viscoelastic ball, with one constant of dissipation" +
            std::string(r.constants.with_memory ? " and impacts taken as independent" : "") +
            ": gamma = " + fit::in_words(r.constants.gamma->value, r.constants.gamma->se) + ".";
  if (!unknown.empty())
    text += " These " + std::to_string(r.law.n) + " impacts do not determine the constants " + joined(unknown) +
            " of the law; they determine the curve.";
  return text.empty() ? text : text.substr(1);
}

namespace {

/// Do the samples scatter as the fit that is quoted assumes? Empty where it was not tested.
std::string scatter_as_assumed(const FitResult& r) {
  const LawFit& law = r.law;
  if (memory_holds(r)) {
    const auto& test = r.memory->anderson_darling;
    return test ? formatted(
                      " The impacts are scattered as the fit with memory assumes (Anderson-Darling: p = %.2g, the "
                      "chance of a worse one).",
                      test->p_value)
                : "";
  }
  if (!law.pearson || r.constants.status == FitStatus::not_applicable) return "";
  if (law.pearson->p_value < 0.001)
    return formatted(" The scatter is not as the fit assumes (p = %.1e, the chance of a worse one); ",
                     law.pearson->p_value) +
           (law.drops.errors == ErrorBasis::by_drop ? "errors between drops do not depend on it."
                                                    : "errors may be too small.");
  return formatted(
      " The samples are scattered as the fit assumes (χ²/ndf = %.2f, 1 expected; p = %.2g, the chance of a worse one).",
      law.pearson->chi2 / law.pearson->ndf, law.pearson->p_value);
}

std::string certainty(const FitResult& r, const SampleConditions& conditions) {
  std::vector<std::string> intervals;
  for (const CurveNode& node : r.curve->nodes)
    intervals.push_back(interval_in_words(node.eps) + formatted(" at %.3g m/s", node.v_mps));
  const std::string text =
      "95 % intervals (19 of 20 such intervals hold the true value): ε from " + joined(intervals) +
      (r.curve->n_drops > 1      ? formatted("; they include how the %zu drops differ.", r.curve->n_drops)
       : conditions.of_flights() ? std::string(", of this drop: how much other drops differ from it is not known.")
                                 : std::string(".")) +
      scatter_as_assumed(r);
  return r.constants.parameters.size() > 1 && !describe_constants(r.constants.parameters).empty()
             ? text + " The constants are correlated: use them with their correlation, or quote the curve."
             : text;
}

/// The row in the middle of the speeds stands for the others.
std::string limits(const FitResult& r, const std::string& measured) {
  if (r.budget.rows.empty()) return "Not known: too few samples.";
  const BudgetRow& row = r.budget.rows[r.budget.rows.size() / 2];
  std::vector<std::string> parts;
  const auto part = [&](double share, const std::string& cause) {
    if (share >= 0.001) parts.push_back(formatted("%.*f %% ", share < 0.1 ? 1 : 0, 100.0 * share) + cause);
  };
  part(row.share_asperities, "the ball itself");
  part(row.share_timing, measured == "times" ? "timing" : "measuring the " + measured);
  part(row.share_travel_time, "travel time of the sound");
  part(row.share_unexplained, "not explained");
  std::string text = formatted("Of the scatter of ε from bounce to bounce, as variance at %.2g m/s: ", row.v_mps) +
                     joined(parts) + ".";
  // two exponentials have a kurtosis of 6: the variance of n samples is known to sqrt(5/n)
  if (const double random_share = std::sqrt(5.0 / static_cast<double>(row.n));
      row.share_unexplained >= 0.001 && row.n > 0)
    text += formatted(" (These shares come from %zu samples: they may be wrong by %.0f %% of the variance.)", row.n,
                      std::min(100.0, 100.0 * random_share));
  // the shares of two that depend on each other may both be 100 %
  const double contact = r.curve->share_of_contact, drag = r.curve->share_of_drag;
  const CurveNode& middle = r.curve->nodes[r.curve->nodes.size() / 2];
  if (middle.eps.se) {
    const double differ = r.curve->scatter_of_drops.value_or(0.0);
    const bool drops_differ = differ > 0.5 * r.curve->scatter &&
                              differ > 0.5 * *middle.eps.se * std::sqrt(static_cast<double>(r.curve->n_drops));
    text += formatted(" Of %zu bounces", r.n_used) +
            (r.curve->n_drops > 1 ? formatted(" in %zu drops", r.curve->n_drops) : "") +
            formatted(" that leaves a standard error of %.2g at %.2g m/s; four times as many ",
                      *middle.eps.se * std::sqrt(std::max(0.0, 1.0 - std::max(contact, drag))), middle.v_mps) +
            (drops_differ ? "drops, which differ, halve it." : "bounces halve it.");
  }
  if (std::max(contact, drag) >= 0.01)
    text += formatted(" Of the variance of the answer %.0f %% is ", 100.0 * std::max(contact, drag)) +
            (drag > contact ? "how strongly the air slows the ball." : "how long the ball touches the floor.");
  return text;
}

std::string gaussian(const std::vector<HistogramFit>& histograms) {
  constexpr double kDecided = 10.0;
  std::size_t n = 0, n_against = 0, n_for = 0, n_unequal = 0;
  double least = HUGE_VAL, most = -HUGE_VAL;
  std::vector<std::string> ratios;
  for (const HistogramFit& h : histograms) {
    if (!h.normal) continue;
    ++n;
    n_against += h.normal->delta_aic > kDecided;
    n_for += h.normal->delta_aic < -kDecided;
    n_unequal += slopes_differ(h).value_or(false);
    if (h.slope_ratio && h.slope_ratio->ci95)
      ratios.push_back(formatted("; falling over rising at %.2g m/s: %.2f (95 %%: %.3f to %.3f)", h.v_mps,
                                 h.slope_ratio->value, h.slope_ratio->ci95->lo, h.slope_ratio->ci95->hi));
    least = std::min(least, h.normal->delta_aic);
    most = std::max(most, h.normal->delta_aic);
  }
  if (n == 0) return "Not known: too few samples at any one speed.";
  const auto of = [&](std::size_t k) { return formatted("%zu of %zu", k, n); };
  const std::string head = n_against == n      ? "No"
                           : n_for == n        ? "Yes"
                           : n_against > n_for ? "Probably not"
                                               : "Undecided";
  return head + ": two exponentials describe the scatter better than a normal distribution in " + of(n_against) +
         " windows of speed, the normal distribution is better in " + of(n_for) +
         formatted(" (better: by more than %.0f in Akaike's criterion, AIC)", kDecided) +
         formatted(" (AIC of the normal less that of the two exponentials: %.0f to %.0f). ", least, most) +
         "Their slopes differ (95 %) in " + of(n_unequal) + " windows" +
         (ratios.empty() ? "" : ratios[ratios.size() / 2]) + ".";
}

std::string remembers(const FitResult& r) {
  const MemoryFit& memory = *r.memory;
  if (!memory_holds(r)) return "No, or not so that it could be used: " + in_words(memory) + ".";
  const std::string constants = describe_constants(r.law.parameters);
  return "Yes: " + in_words(memory) + ". All constants above are by this fit" +
         (constants.empty() ? "" : "; for comparison, impacts taken as independent give " + constants) +
         ". The surface: " + in_words(memory.roughness) + ".";
}

std::string in_dem(const FitResult& r) {
  if (!r.is_one_ball) return "Not of these samples together: one value for all would belong to no ball.";
  if (!r.dem_export) return "Not at all: ε is not between 0 and 1 there.";
  const fit::DemExport& d = *r.dem_export;
  return formatted(
             "As a constant: √⟨ε²⟩ = %s at %.2g m/s, which keeps the energy; choose the speed of your collisions. ",
             fit::in_words(d.eps, d.se).c_str(), d.v_mps) +
         (d.gamma ? "With the speed: viscoelastic contacts. " : "") +
         "Inputs of LIGGGHTS, LAMMPS, Yade and MercuryDPM" + " that run, and functions that draw the fluctuations" +
         (memory_holds(r) ? " with memory" : "") +
         ": `bouncelab dem fit.json --code lammps` prints them, and the report has them at its end.";
}

// Why eps is not the same at every bounce: the speed, the air, the roughness, each by its size in this recording.

std::string speed_text(double v_mps) { return formatted("%.2g m/s", v_mps); }

/// The change of eps between the least and the greatest speed; seen where the answer states one.
Cause of_speed(const FitResult& result, const PlainAnswer& answer) {
  const auto& step = result.curve->step;
  Cause cause{"speed", {}, !answer.elsewhere.empty() || step, {}};
  const auto& points = result.curve->points;
  cause.sentence = "The effect of the speed is not known: the impacts have too few different speeds.";
  if (points.empty()) return cause;
  const CurvePoint &slow = points.front(), &fast = points.back();
  double from_mps = slow.x, to_mps = fast.x, change = fast.y - slow.y;
  const auto& elsewhere = answer.elsewhere;
  if (elsewhere.size() == 1) {  // what the other end does is not seen
    const auto [slower, faster] =
        std::minmax(*answer.at, elsewhere[0], [](auto& a, auto& b) { return a.v_mps < b.v_mps; });
    from_mps = slower.v_mps, to_mps = faster.v_mps, change = faster.eps.value - slower.eps.value;
  }
  cause.size = std::abs(change);
  const std::string between = " between " + speed_text(from_mps) + " and " + speed_text(to_mps);
  const double at_fast = fast.y - answer.at->eps.value, at_slow = slow.y - answer.at->eps.value;
  if (!cause.is_seen)
    cause.sentence = "No effect of the speed is seen" + between + ".";
  else if (step)
    cause.sentence = "the surface that the ball meets: ε steps by " + two_digits(std::abs(step->change.value)) +
                     " at " + speed_text(step->v_mps) + ", and goes from " + two_digits(slow.y) + " to " +
                     two_digits(fast.y) + between + ".";
  else if (elsewhere.size() == 2 && at_fast * at_slow > 0.0) {
    cause.size = std::max(std::abs(at_fast), std::abs(at_slow));
    cause.sentence = "the speed: from its value at " + speed_text(answer.at->v_mps) +
                     (at_fast < 0.0 ? " ε falls by " : " ε rises by ") + two_digits(std::abs(at_slow)) + " towards " +
                     speed_text(slow.x) + " and by " + two_digits(std::abs(at_fast)) + " towards " +
                     speed_text(fast.x) + ".";
  } else if (change < 0.0)
    cause.sentence = "the speed: a faster ball is pressed in more and loses more, ε falls by " +
                     two_digits(*cause.size) + between + ".";
  else
    cause.sentence = "the speed: ε rises by " + two_digits(*cause.size) + between + ".";
  return cause;
}

bool ball_is_named(const RestitutionSamples& samples) {
  return !samples.empty() && samples.front().conditions.ball.has_value();
}

/// What drag takes from eps as the intervals have it, and as much as heights do, at the fastest bounce more than at the
/// slowest: eps kappa v^2 (1 + eps^2) / (4 g), docs/physics.md.
Cause of_air(const FitResult& result, const PlainAnswer& answer, const RestitutionSamples& samples) {
  Cause cause{"air", {}, false, {}};
  const auto& points = result.curve->points;
  cause.sentence = "No effect of the air is seen or taken into account.";
  if (!result.curve->kappa_per_m) return cause;
  const double g_mps2 = samples.front().conditions.gravity_mps2.value_or(kDefaultGravity_mps2);
  const Estimate& kappa_per_m = *result.curve->kappa_per_m;
  const bool one_speed = points.empty();  // the effect itself, else what it changes from slow to fast
  const double eps = answer.at->eps.value, fast = one_speed ? answer.at->v_mps : points.back().x,
               slow = one_speed ? 0.0 : points.front().x;
  const double by_kappa = eps * (1.0 + eps * eps) * (square(fast) - square(slow)) / (4.0 * g_mps2);
  if (!ball_is_named(samples)) {
    cause.sentence = "The effect of the air is not known";
    if (kappa_per_m.ci95)
      cause.sentence += " (" + two_digits(by_kappa * kappa_per_m.ci95->lo) + " to " +
                        two_digits(by_kappa * kappa_per_m.ci95->hi) + " in ε)";
    cause.sentence += ": name the ball.";
    return cause;
  }
  cause.size = by_kappa * kappa_per_m.value;
  cause.is_seen = true;
  cause.sentence =
      std::string("the air, which slows fast flights most: ") +
      (samples.front().conditions.of_heights ? "the heights make" : "the time from bounce to bounce makes") +
      " ε look " + two_digits(*cause.size) + " smaller at " + speed_text(fast) +
      (one_speed ? "" : " than at " + speed_text(slow)) + " (taken out of the values here).";
  return cause;
}

/// The width of the band that holds two thirds of the bounces, at the middle speeds; seen where it is wider than the
/// errors of the times make it.
Cause of_roughness(const FitResult& result, const RestitutionSamples& samples) {
  Cause cause{"roughness", {}, false, {}};
  const auto& rows = result.budget.rows;
  const BudgetRow* row = rows.empty() ? nullptr : &rows[rows.size() / 2];
  constexpr std::size_t kFewestOfAWidth = 8;  // of fewer it is not known to a quarter
  cause.sentence = "The roughness of ball and floor is not known: there are too few bounces.";
  if (!row || !row->spread_asperities || result.n_used < kFewestOfAWidth) return cause;
  // what a law misses, or drops differ by, is no scatter of bounces
  const double spread = std::min(*row->spread_asperities, result.curve->scatter);
  cause.size = 2.0 * spread;
  const double timing = std::max(row->spread_timing_stated.value_or(0.0), row->spread_timing_lag1.value_or(0.0));
  cause.is_seen = spread > timing;
  const std::string errors = std::string("errors of the ") + measured_in_words(samples.front().conditions);
  cause.sentence = cause.is_seen
                       ? "the roughness of ball and floor: each bounce meets another spot, which turns some of "
                         "the motion into spin or back; two thirds of the bounces lie in a band of " +
                             two_digits(*cause.size) + ", wider than " + errors + " make it."
                       : "No roughness of ball or floor is seen: the " + errors + " explain the scatter of ε.";
  return cause;
}

}  // namespace

std::vector<Cause> causes_of(const FitResult& result, const PlainAnswer& answer, const RestitutionSamples& samples) {
  if (!answer.at) return {};
  std::vector<Cause> causes{of_speed(result, answer), of_air(result, answer, samples), of_roughness(result, samples)};
  std::stable_sort(causes.begin(), causes.end(), [](const Cause& a, const Cause& b) {
    return (a.is_seen ? *a.size : -1.0) > (b.is_seen ? *b.size : -1.0);
  });
  const bool air_is_open = result.curve->kappa_per_m && !ball_is_named(samples);
  for (std::size_t k = 0; k < causes.size(); ++k)
    if (causes[k].is_seen)
      causes[k].sentence = (k == 0 ? (air_is_open ? "Of what is seen, mostly " : "Mostly ")
                            : *causes[k].size > 0.5 * *causes[0].size ? "Nearly as much "
                            : *causes[k].size > 0.1 * *causes[0].size ? "Less "
                                                                      : "Hardly ") +
                           causes[k].sentence;
  return causes;
}

std::string objections_in_words(const MemoryFit& memory) {
  std::string text;
  for (const std::string& one : texts_of(memory.objections)) text += (text.empty() ? "" : "; ") + one;
  return text;
}

std::string in_words(const MemoryFit& memory) {
  if (memory.status != FitStatus::ok) return "memory could not be fitted: " + objections_in_words(memory);
  if (!memory.holds)
    return "the fit with memory does not hold for these impacts: " + objections_in_words(memory) +
           "; use the curve ε(v) of the fit with independent impacts";
  std::string text = "the fluctuations remember those before them, as a rough ball's do: ";
  if (memory.loglik_independent)
    text += formatted("log-likelihood %.1f above that of independent impacts, ",
                      memory.loglik - *memory.loglik_independent);
  if (memory.anderson_darling)
    text +=
        formatted("Anderson-Darling test of the probability transforms p = %.2g, ", memory.anderson_darling->p_value);
  text += formatted("offset and width of the scatter by one roughness p = %.2g, as rough at every speed p = %.2g",
                    memory.mechanism.p_value, memory.by_speed.p_value);
  if (memory.between_drops) text += formatted(", drops alike p = %.2g", memory.between_drops->p_value);
  const Estimate leak = leak_of(memory);
  return text + "; share of the reservoir that an impact loses " + fit::in_words(leak.value, leak.se) +
         formatted(" (p = %.2g against none)", memory.leak.p_value);
}

std::string in_words(const Roughness& r) {
  std::string text = formatted("q = %.3g", r.q.value);
  if (r.q.se) text += formatted(" ± %.1g", *r.q.se);
  if (r.q.ci95) text += formatted(" (95 %%: %.3g to %.3g)", r.q.ci95->lo, r.q.ci95->hi);
  return text + formatted(", rms tilt of the contact's normal %.2g degrees without slip", r.rms_tilt_no_slip_deg);
}

std::vector<Finding> findings_of(const FitResult& result, const SampleConditions& conditions) {
  if (!result.curve) return {};
  std::vector<Finding> findings;
  if (result.is_one_ball)
    findings = {{"How does ε depend on speed?", dependence(result)},
                {"How sure is that?", certainty(result, conditions)},
                {"What limits it?", limits(result, measured_in_words(conditions))},
                {"Is the scatter Gaussian?", gaussian(result.histograms)}};
  findings.push_back({"How do I use it in a DEM code?", in_dem(result)});
  if (std::string agreement = in_words(result.recordings); !agreement.empty())
    findings.insert(
        findings.begin() + (result.is_one_ball ? 1 : 0),
        {!result.recordings.plates.empty() ? "Do the plates agree?" : "Do the recordings agree?", sentence(agreement)});
  if (result.memory && result.is_one_ball)
    findings.insert(findings.end() - 1, {"Do the fluctuations remember?", remembers(result)});
  return findings;
}

}  // namespace bouncelab::report
