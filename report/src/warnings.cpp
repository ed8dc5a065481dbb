// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/usable_samples.hpp"
#include "words.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

/// One line for all pairs: the worst one stands for them.
void warn_of_correlation(const Constants& law, std::vector<std::string>& warnings) {
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
  warnings.push_back(
      law.parameters[worst_j].name + " and " + law.parameters[worst_i].name +
      formatted(" cannot be told apart with these speeds: their correlation is %.4f; use the curve ε(v), "
                "or the constants with their covariance",
                law.correlation[worst_i][worst_j]));
}

/// The constants matter to few and the curve is known without them: their warnings come last.
void warn_of_constants(const Constants& law, std::vector<std::string>& warnings) {
  warn_of_correlation(law, warnings);
  if (!law.message.empty() && law.status == FitStatus::not_identifiable) warnings.push_back(law.message);
}

/// What one drop's impacts share cannot be seen without other drops. (Figures: docs/physics.md, errors by drop.)
void warn_of_few_drops(const DropCount& drops, std::vector<std::string>& warnings) {
  if (drops.n == 0 || drops.errors == ErrorBasis::by_drop) return;
  const std::string why = drops.n >= kFewestDrops
                              ? "nearly all that is known comes from one drop"
                              : formatted("%zu drop%s, fewer than %zu", drops.n, drops.n == 1 ? "" : "s", kFewestDrops);
  warnings.push_back(why +
                     ": standard errors take impacts as independent, of the constants and of the slopes of p(ε); those "
                     "of the slopes may be up to 1.7 times too small at low speeds");
}

/// Drops that differ by more than single bounces do, and visibly: something is another from drop to drop.
void warn_of_drops_that_differ(const FitResult& result, std::vector<std::string>& warnings) {
  constexpr double kOfLost = 0.05;
  if (!result.is_one_ball || !result.curve || !result.curve->scatter_of_drops) return;
  const Curve& curve = *result.curve;
  const double differ = *curve.scatter_of_drops, eps = curve.nodes[curve.nodes.size() / 2].eps.value;
  if (differ < curve.scatter || differ < kOfLost * (1.0 - eps)) return;
  warnings.push_back(formatted(
      "the %zu drops differ by more (%.2g in ε) than bounces of one do (%.2g), which makes the interval wide: "
      "another ball, spot or release? More drops narrow it",
      curve.n_drops, differ, curve.scatter));
}

void warn_of_law(const FitResult& result, std::vector<std::string>& warnings) {
  const LawFit& law = result.law;
  if (result.constants.status == FitStatus::not_applicable) return;  // they are none about it
  // with memory the impacts need not scatter as if they were independent
  if (law.p_value && *law.p_value < 0.001 && !memory_holds(result)) {
    double ratio = 0.0;
    for (const ResidualBin& bin : law.residuals) ratio += bin.scatter_ratio / static_cast<double>(law.residuals.size());
    warnings.push_back(formatted("the scatter about the law is not as the fit assumes: χ²/ndf = %.2f, p = %.1e; ",
                                 *law.chi2 / static_cast<double>(*law.ndf), *law.p_value) +
                       (ratio < 0.8 ? formatted("it is %.2f of what the stated timing errors alone explain: these are "
                                                "stated too large, and so are all errors given here",
                                                ratio)
                        : law.drops.errors == ErrorBasis::by_drop
                            ? "standard errors are by drop and do not depend on it"
                            : "standard errors may be too small"));
  }
  if (!law.outliers.empty())
    warnings.push_back(formatted(
        "%zu bounce%s too far from ε(v) for the scatter of the others and left out: missed or invented impacts?",
        law.outliers.size(), law.outliers.size() == 1 ? " is" : "s are"));
}

/// Where the noise that neighbouring samples share is not what the detector states.
/// Beyond the speeds measured, by more than a tenth, it is the law that speaks.
void warn_of_nodes(const std::vector<NodeEstimate>& nodes, const RestitutionSamples& used,
                   std::vector<std::string>& warnings) {
  if (used.empty()) return;
  const auto [slowest, fastest] =
      std::minmax_element(used.begin(), used.end(), [](const auto& a, const auto& b) { return a.v_mps < b.v_mps; });
  for (const NodeEstimate& node : nodes)
    if (node.v_mps < 0.9 * slowest->v_mps || node.v_mps > 1.1 * fastest->v_mps) {
      warnings.push_back(formatted("ε at %.3g m/s is the law continued: speeds from %.3g to %.3g m/s were measured",
                                   node.v_mps, slowest->v_mps, fastest->v_mps));
      return;
    }
}

void warn_of_timing(const ErrorBudget& budget, std::vector<std::string>& warnings) {
  if (!budget.timing || !budget.timing->stated_s || !(*budget.timing->stated_s > 0.0)) return;
  const TimingNoise& t = *budget.timing;
  const double stated2 = *t.stated_s * *t.stated_s;
  if (std::abs(t.variance_s2 - stated2) < 4.0 * t.variance_se_s2 || !t.sigma_s) return;
  // a tenth of the noise is of no consequence however well it is measured
  if (std::abs(*t.sigma_s / *t.stated_s - 1.0) < 0.1) return;
  warnings.push_back(formatted("neighbouring samples show a timing noise of %.2g us where %.2g us are stated",
                               *t.sigma_s * 1e6, *t.stated_s * 1e6));
}

void warn_of_unstated_errors(const RestitutionSamples& used, std::vector<std::string>& warnings) {
  const auto unknown =
      std::count_if(used.begin(), used.end(), [](const auto& s) { return !s.sigma_eps || !(*s.sigma_eps > 0.0); });
  if (unknown > 0)
    warnings.push_back(
        formatted("%td of %zu samples state no timing error: it is neglected there, and the scatter "
                  "includes it",
                  unknown, used.size()));
}

/// Rows that a flag of the detector or of the intervals excludes were counted where the flag was set. Rows that are
/// excluded by their values, or by a word that nothing of ours writes, were not.
void warn_of_rows_left_out(const LeftOut& left_out, std::vector<std::string>& warnings) {
  for (const auto& [reason, first] : left_out.first) {
    const std::optional<Flag> flag = flag_named(reason);
    if (flag && *flag != Flag::not_finite) continue;
    std::string in_words = "flag " + reason;
    if (flag) in_words = "not finite";
    if (reason == "speed_not_positive") in_words = "speed not positive";
    if (reason == "contact_most_of_bounce") in_words = "the ball named touches the floor for most of that bounce";
    warnings.push_back(formatted("%zu of the samples left out: %s; the first is number %zu", left_out.n.at(reason),
                                 in_words.c_str(), first));
  }
}

/// Few are told where the flags were set; of many it is likelier that the rule is wrong.
void warn_of_wrong_intervals(const RestitutionSamples& used, const LeftOut& left_out,
                             std::vector<std::string>& warnings) {
  constexpr double kMany = 0.2;
  std::size_t n = 0, n_all = used.size();
  for (const auto& [reason, n_here] : left_out.n) {
    n_all += n_here;
    if (reason == name_of(Flag::missing_impact) || reason == name_of(Flag::extra_impact)) n += n_here;
  }
  if (static_cast<double>(n) > kMany * static_cast<double>(n_all))
    warnings.push_back(
        formatted("%zu of %zu bounces are left out, since their intervals look as if an impact was missed "
                  "or is none: look at the times there",
                  n, n_all));
}

void warn_of_mixed_conditions(const RestitutionSamples& used, std::vector<std::string>& warnings) {
  const auto differs = [&](const RestitutionSample& s) { return s.conditions != used.front().conditions; };
  const auto n = std::count_if(used.begin(), used.end(), differs);
  if (n > 0)
    warnings.push_back(
        formatted("%td of the samples were computed with other corrections, or for another ball, gravity or "
                  "wave speed than the first: drag, contact time and error budget are taken as of the first",
                  n));
}

/// Of the samples alone, whatever is fitted to them.
void warn_of_all_samples(const RestitutionSamples& used, const LeftOut& left_out, std::vector<std::string>& warnings) {
  if (auto twice = warning_of_repeated_drops(used)) warnings.push_back(*std::move(twice));
  Implausible implausible;
  for (const RestitutionSample& sample : used) implausible.add(sample);
  for (std::string& warning : implausible.warnings()) warnings.push_back(std::move(warning));
  warn_of_rows_left_out(left_out, warnings);
  warn_of_wrong_intervals(used, left_out, warnings);
  warn_of_mixed_conditions(used, warnings);
}

/// What is open of the fit with memory, which needs a radius and a moment of inertia.
std::string open_without_ball(const MemoryFit& memory) {
  if (memory.status != FitStatus::ok || memory.ball) return "";
  return formatted(
      "no ball was named (--ball): the fit with memory takes a solid one, J = %.3g m R^2, of %.3g mm radius",
      kSolidBallInertia, 1e3 * Ball{}.radius_m);
}

}  // namespace

void Implausible::add(const RestitutionSample& sample) {
  ++n_;
  if (sample.eps > 1.0) ++n_above_one_;
  if (sample.eps < 0.0) ++n_below_zero_;
  if (sample.v_mps > 20.0 || sample.v_mps < 0.005) ++n_speeds_;
  of_heights_ = sample.conditions.of_heights;
}

std::vector<std::string> Implausible::warnings() const {
  std::vector<std::string> warnings;
  const auto warn = [&](std::size_t n, const char* words, const char* doubt) {
    if (10 * n > n_) warnings.push_back(formatted("%zu of %zu %s: %s?", n, n_, words, doubt));
  };
  warn(n_above_one_, "samples have ε > 1", "time order or units of the input");
  warn(n_below_zero_, "samples have ε < 0", "time order or columns of the input");
  warn(n_speeds_, "speeds are outside 0.005 to 20 m/s",
       of_heights_ ? "are heights in the unit that was said, and gravity in m/s^2"
                   : "are times in seconds, and gravity in m/s^2");
  return warnings;
}

std::optional<std::string> warning_of_repeated_drops(const RestitutionSamples& used) {
  const std::vector<RepeatedDrop> repeated = repeated_drops(used);
  if (repeated.empty()) return std::nullopt;
  const auto name = [](const std::string& recording, std::int64_t drop) {
    return "drop " + std::to_string(drop) + (recording.empty() ? "" : " of " + printable(recording));
  };
  const RepeatedDrop& first = repeated.front();
  return name(first.recording, first.drop) + " has the bounces of " + name(first.of_recording, first.of_drop) +
         formatted(" (%zu of them)", first.n_bounces) +
         (repeated.size() > 1 ? formatted(", and so have %zu more drops of others", repeated.size() - 1) : "") +
         ": the same drop twice? Leave copies out, or the errors are too small";
}

void warn(const FitResult& result, const RestitutionSamples& samples, FitInWords& words) {
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  const RestitutionSamples& used = *part;
  // what may make another answer comes first; what only some ask for is a detail
  std::vector<std::string>& first = words.warnings;
  if (disagree(result.recordings)) first.push_back(in_words(result.recordings));
  if (result.kinds_of_drops && result.is_one_ball) first.push_back(in_words(*result.kinds_of_drops));
  warn_of_all_samples(used, left_out, first);
  warn_of_drops_that_differ(result, first);
  // why there are no constants is a detail where eps is known all the same
  const Constants& constants = result.constants;
  const bool no_law = !constants.message.empty() && constants.status != FitStatus::not_identifiable;
  if (no_law && !result.curve) first.push_back(constants.message);
  warn_of_law(result, first);
  if (result.curve) warn_of_nodes(result.curve->nodes, used, first);
  if (result.dem_export) warn_of_nodes({{result.dem_export->v_mps, {}}}, used, first);
  warn_of_timing(result.budget, first);
  std::vector<std::string>& details = words.details;
  if (first.size() > kMostWarnings) {
    details.assign(first.begin() + kMostWarnings, first.end());
    first.resize(kMostWarnings);
  }
  if (no_law && result.curve) details.push_back(constants.message);
  details.insert(details.end(), result.law.notes.begin(), result.law.notes.end());
  if (!memory_holds(result)) warn_of_few_drops(result.law.drops, details);
  warn_of_unstated_errors(used, details);
  if (const std::string open = result.memory ? open_without_ball(*result.memory) : ""; !open.empty())
    details.push_back(open);
  warn_of_constants(constants, details);
}

std::vector<std::string> warnings_of(const RoughnessResult& result, const RestitutionSamples& samples) {
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  std::vector<std::string> warnings;
  warn_of_all_samples(*part, left_out, warnings);
  if (const std::string open = open_without_ball(result.memory); !open.empty()) warnings.push_back(open);
  return warnings;
}

}  // namespace bouncelab::report
