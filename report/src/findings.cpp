// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "bouncelab/core/ball.hpp"
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
  std::vector<std::string> unknown;
  for (const NamedEstimate& p : r.constants.parameters)
    if (!p.estimate.identified) unknown.push_back(p.name);
  const std::string known = describe_constants(r.constants.parameters);
  std::string text = "ε = " + describe_nodes(*r.curve) + " (± one standard error)." + other_centres(*r.curve);
  if (!known.empty())
    text += " Constants of the law: " + known + (r.constants.with_memory ? " (by the fit with memory)." : ".");
  if (r.constants.status == FitStatus::not_applicable && r.constants.why) text += " " + as_sentence(*r.constants.why);
  if (r.constants.gamma)
    text += " As a viscoelastic ball, with one constant of dissipation" +
            std::string(r.constants.with_memory ? " and impacts taken as independent" : "") +
            ": gamma = " + fit::in_words(r.constants.gamma->value, r.constants.gamma->se) + ".";
  if (!unknown.empty())
    text += " These " + std::to_string(r.law.n) + " impacts do not determine the constants " + joined(unknown) +
            " of the law; they determine the curve.";
  return text;
}

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
  if (!law.p_value || r.constants.status == FitStatus::not_applicable) return "";
  if (*law.p_value < 0.001)
    return formatted(" The scatter is not as the fit assumes (p = %.1e, the chance of a worse one); ", *law.p_value) +
           (law.drops.errors == ErrorBasis::by_drop ? "errors between drops do not depend on it."
                                                    : "errors may be too small.");
  return formatted(
      " The samples are scattered as the fit assumes (χ²/ndf = %.2f, 1 expected; p = %.2g, the chance of a worse one).",
      *law.chi2 / static_cast<double>(*law.ndf), *law.p_value);
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
  const auto shift = [&](std::optional<double> BudgetRow::*member, const char* cause) {
    const auto& effects = r.budget.effects;
    if (std::none_of(effects.begin(), effects.end(),
                     [&](const auto& effect) { return effect.first == cause && effect.second == Effect::corrected; }))
      return;
    const auto size = [&](const BudgetRow& b) { return std::abs((b.*member).value_or(0.0)); };
    const auto worst = std::max_element(r.budget.rows.begin(), r.budget.rows.end(),
                                        [&](const auto& a, const auto& b) { return size(a) < size(b); });
    if (size(*worst) > 0.0)
      text += formatted(" Corrected: %s, %+.1e in ε at %.2g m/s.", cause, *((*worst).*member), worst->v_mps);
  };
  const std::size_t before = text.size();
  shift(&BudgetRow::shift_drag, "air drag");
  shift(&BudgetRow::shift_contact_time, "contact time");
  if (text.size() != before)
    text += " (For " + to_text(*r.budget.ball) + (r.budget.plate ? " on " + plate_text(*r.budget.plate) : "") + ".)";
  return text;
}

std::string gaussian(const std::vector<HistogramFit>& histograms) {
  constexpr double kDecided = 10.0;
  std::size_t n = 0, n_against = 0, n_for = 0, n_unequal = 0;
  double least = HUGE_VAL, most = -HUGE_VAL;
  std::vector<std::string> ratios;
  for (const HistogramFit& h : histograms) {
    if (!h.delta_aic_gaussian) continue;
    ++n;
    n_against += *h.delta_aic_gaussian > kDecided;
    n_for += *h.delta_aic_gaussian < -kDecided;
    n_unequal += slopes_differ(h).value_or(false);
    if (h.slope_ratio && h.slope_ratio->ci95)
      ratios.push_back(formatted("; falling over rising at %.2g m/s: %.2f (95 %%: %.3f to %.3f)", h.v_mps,
                                 h.slope_ratio->value, h.slope_ratio->ci95->lo, h.slope_ratio->ci95->hi));
    least = std::min(least, *h.delta_aic_gaussian);
    most = std::max(most, *h.delta_aic_gaussian);
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
         (memory_holds(r) ? ", with memory," : "") +
         " are at the end, and `bouncelab dem fit.json --code lammps` prints them.";
}

}  // namespace

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
    findings.insert(findings.begin() + (result.is_one_ball ? 1 : 0), {"Do the recordings agree?", sentence(agreement)});
  if (result.memory && result.is_one_ball)
    findings.insert(findings.end() - 1, {"Do the fluctuations remember?", remembers(result)});
  return findings;
}

}  // namespace bouncelab::report
