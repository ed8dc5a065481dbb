// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "words.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

/// <eps^2> - peak^2 of the scatter at v.
double mean_square_above_peak(const LawFit& law, double v_mps) {
  return law.law ? square(rms_restitution(law, v_mps)) - square(restitution(*law.law, v_mps)) : 0.0;
}

SpeedAndRestitution at_node(const NodeEstimate& node, const LawFit& scatter) {
  return {node.v_mps, node.eps, 1.0 - square(node.eps.value) - mean_square_above_peak(scatter, node.v_mps)};
}

/// Decimals that show one digit of a standard error, two where that one is 1.
int decimals_for(const Estimate& e) {
  if (!e.se || !(*e.se > 0.0) || !std::isfinite(*e.se)) return 3;
  const double exponent = std::floor(log10(*e.se));
  const bool begins_with_1 = *e.se < 1.95 * pow(10.0, exponent);
  return std::clamp(static_cast<int>(-exponent) + (begins_with_1 ? 1 : 0), 1, 8);
}

std::string rounded(double value, int decimals) { return formatted("%.*f", decimals, value); }

/// "0.9477 ± 0.0003 (95 %: 0.9470 to 0.9484)"; without ± where the interval reaches beyond three standard errors, since
/// whoever doubles one would believe too much.
std::string with_interval(const Estimate& e) {
  const int decimals = decimals_for(e);
  std::string text = rounded(e.value, decimals);
  const double reach = e.ci95 ? std::max(e.ci95->hi - e.value, e.value - e.ci95->lo) : 0.0;
  if (e.se && *e.se > 0.0 && reach <= 3.0 * *e.se) text += " ± " + rounded(*e.se, decimals);
  if (e.ci95) text += " (95 %: " + interval_in_words(e) + ")";
  return text;
}

std::string speed(double v_mps) { return formatted("%.3g m/s", v_mps); }

int decimals_of_two_digits(double x) { return x > 0.0 ? std::max(0, 1 - static_cast<int>(std::floor(log10(x)))) : 0; }

/// Two digits, without a power of ten.
std::string two_digits(double x) { return rounded(x, decimals_of_two_digits(x)); }

/// A unit that suits a length, and how many of it make a metre.
std::pair<const char*, double> unit_of(double length_m) {
  if (length_m < 0.01) return {" mm", 1e3};
  if (length_m < 1.0) return {" cm", 1e2};
  return {" m", 1.0};
}

/// "about 1.02 m (0.96 to 1.07 m)". An interval of more than a factor of two says too little of a height to name one:
/// its lower end alone is said, rounded down, since the next flight proves most of that.
std::string height(double h_m, const std::optional<Interval>& ci95_m, const std::string& remark) {
  const bool is_known = !ci95_m || ci95_m->hi <= 2.0 * ci95_m->lo;
  const auto [unit, per_m] = unit_of(is_known ? h_m : ci95_m->lo);
  std::string brackets = remark, text;
  if (!ci95_m) {
    text = "about " + two_digits(per_m * h_m) + unit;
  } else if (is_known) {
    const int of_width = decimals_of_two_digits(0.5 * per_m * (ci95_m->hi - ci95_m->lo)) - 1;
    const int decimals = std::max(decimals_of_two_digits(per_m * h_m), std::min(of_width, 4));
    const auto length = [decimals, scale = per_m](double x_m) { return rounded(scale * x_m, decimals); };
    text = "about " + length(h_m) + unit;
    brackets = length(ci95_m->lo) + " to " + length(ci95_m->hi) + unit + (remark.empty() ? "" : "; " + remark);
  } else {
    const double scale = pow(10.0, decimals_of_two_digits(per_m * ci95_m->lo));
    text = "at least " + two_digits(std::floor(per_m * ci95_m->lo * scale) / scale) + unit;
  }
  return brackets.empty() ? text : text + " (" + brackets + ")";
}

/// "2.7 to 30 cm"
std::string lengths(const Interval& of_drops_m) {
  const auto [unit, per_m] = unit_of(of_drops_m.hi);
  return two_digits(per_m * of_drops_m.lo) + " to " + two_digits(per_m * of_drops_m.hi) + unit;
}

std::string duration(double t_s) {
  return t_s < 120.0    ? two_digits(t_s) + " s"
         : t_s < 7200.0 ? two_digits(t_s / 60.0) + " min"
                        : two_digits(t_s / 3600.0) + " h";
}

/// Is eps at node `k` another than at the middle one, whatever drag, contact time and law are?
bool differs(const FitResult& result, const std::vector<NodeEstimate>& nodes, const Matrix& correlation,
             std::size_t k) {
  const std::size_t middle = nodes.size() / 2;
  if (k == middle) return false;
  if (result.averaged && result.averaged->nodes.size() == nodes.size() && &nodes == &result.averaged->nodes) {
    const Interval& change = *result.averaged->changes[k].ci95;
    constexpr double kRounding = 1e-9;  // where a constant is likely, the interval ends at 0 but for rounding
    return change.lo > kRounding || change.hi < -kRounding;
  }
  const Estimate &a = nodes[middle].eps, &b = nodes[k].eps;
  if (!a.se || !b.se) return false;
  constexpr double kSeen = 3.0;  // by chance alone one answer in 200 would name a change; at 2.0 one in 11
  const double rho = k < correlation.size() && middle < correlation[k].size() ? correlation[k][middle] : 0.0;
  const double variance = *a.se * *a.se + *b.se * *b.se - 2.0 * rho * *a.se * *b.se;
  return std::abs(b.value - a.value) > kSeen * std::sqrt(std::max(0.0, variance));
}

/// What most of the uncertainty is, and what would shrink it; empty where it is the ball's own scatter.
std::string largest_part(const FitResult& result, bool ball_is_named) {
  if (!result.averaged) return "";
  constexpr double kMost = 0.5;
  const double drag = result.averaged->share_of_drag, contact = result.averaged->share_of_contact;
  if (std::max(drag, contact) < kMost) return "";
  return std::string("Most of the uncertainty is ") +
         (drag > contact ? "how strongly the air slows the ball" : "how long the ball touches the floor") +
         (ball_is_named ? "." : ": name the ball to narrow it (--ball).");
}

/// The node that most recordings reach; the middle one of equals.
std::optional<double> common_speed(const std::vector<RecordingFit>& rows) {
  std::map<double, std::size_t> n_at;
  for (const RecordingFit& row : rows)
    for (const NodeEstimate& node : row.nodes) ++n_at[node.v_mps];
  if (n_at.empty()) return {};
  std::size_t most = 0;
  for (const auto& [v_mps, n] : n_at) most = std::max(most, n);
  std::vector<double> best;
  for (const auto& [v_mps, n] : n_at)
    if (n == most) best.push_back(v_mps);
  return best[best.size() / 2];
}

std::vector<ReleaseHeight> heights_of(const FitResult& result) {
  return result.averaged ? result.averaged->heights : std::vector<ReleaseHeight>{};
}

std::vector<RecordingAnswer> answers_by_recording(const FitResult& result, const RestitutionSamples& samples) {
  if (result.recordings.rows.empty()) return {};
  std::map<std::string, RestitutionSamples> of;
  for (const RestitutionSample& s : samples) of[s.recording].push_back(s);
  const std::optional<double> v_mps = common_speed(result.recordings.rows);
  std::vector<RecordingAnswer> answers;
  for (const RecordingFit& row : result.recordings.rows) {
    RecordingAnswer answer{
        row.recording, {}, row.nodes.empty() ? row.message : "", drops_seen(of[row.recording], heights_of(result))};
    const NodeEstimate* nearest = nullptr;
    for (const NodeEstimate& node : row.nodes)
      if (!nearest || std::abs(node.v_mps - *v_mps) < std::abs(nearest->v_mps - *v_mps)) nearest = &node;
    if (nearest) answer.at = at_node(*nearest, result.law);
    answers.push_back(std::move(answer));
  }
  return answers;
}

std::string file_name(const std::string& recording) {
  return recording.empty() ? "without name" : printable(std::filesystem::path(recording).filename().string());
}

/// "ε steps from 0.92 to 0.85 at 0.68 m/s, after bounce 17: did the ball reach another surface?"
std::string of_step(const RestitutionStep& step, int decimals) {
  std::string text = "ε steps from " + rounded(step.eps_faster, decimals) + " to " +
                     rounded(step.eps_slower, decimals) + " at " + speed(step.v_mps);
  if (step.impact) text += ", after bounce " + std::to_string(*step.impact + 1);
  return text + ": did the ball reach another surface?";
}

std::string of_value(const PlainAnswer& answer, const FitResult& result) {
  const SpeedAndRestitution& at = *answer.at;
  std::string text = "ε = " + with_interval(at.eps) + " at " + speed(at.v_mps);
  const auto& nodes = quoted_nodes(result);
  // of one eps that was asked for nothing is to be seen
  const bool may_change = result.law.kind != LawKind::constant || !result.averaged || result.averaged->laws.size() > 1;
  if (may_change && answer.elsewhere.empty() && speed(nodes.front().v_mps) != speed(nodes.back().v_mps) &&
      !(result.averaged && result.averaged->step))
    text += "; from " + speed(nodes.front().v_mps) + " to " + speed(nodes.back().v_mps) +
            " no change with the speed is seen";
  std::string verb = "; it ";
  for (const SpeedAndRestitution& other : answer.elsewhere) {
    text += verb + (other.eps.value < at.eps.value ? "falls to " : "rises to ") +
            rounded(other.eps.value, std::min(decimals_for(other.eps), decimals_for(at.eps))) + " at " +
            speed(other.v_mps);
    verb = " and ";
  }
  if (answer.with_memory) text += " (by the fit with memory)";
  return text + ".";
}

/// With one decimal where the standard error, 2 eps se, warrants it.
std::string percent_lost(const SpeedAndRestitution& at) {
  const bool exact = at.eps.se && 200.0 * at.eps.value * *at.eps.se < 0.5;
  return rounded(100.0 * at.energy_lost, exact ? 1 : 0);
}

/// Where the loss is visibly another than that of the peak.
std::string why_not_of_peak(const SpeedAndRestitution& at) {
  return std::abs(at.energy_lost - (1.0 - square(at.eps.value))) < 0.005
             ? ""
             : ", by the mean of ε²: the ε above is the peak of its distribution";
}

/// Where recordings differ by more than chance, or cannot be compared: their range instead of a value.
std::string of_range(const PlainAnswer& answer, bool differ) {
  const RecordingAnswer *least = nullptr, *greatest = nullptr;
  for (const RecordingAnswer& r : answer.recordings) {
    if (!r.at) continue;
    if (!least || r.at->eps.value < least->at->eps.value) least = &r;
    if (!greatest || r.at->eps.value > greatest->at->eps.value) greatest = &r;
  }
  std::string text = formatted(differ ? "The %zu recordings differ by more than chance: "
                                      : "Whether the %zu recordings agree cannot be told, too few bounces of each: ",
                               answer.recordings.size());
  if (least)
    text += "ε runs from " + rounded(least->at->eps.value, decimals_for(least->at->eps)) + " (" +
            file_name(least->recording) + ", " + speed(least->at->v_mps) + ") to " +
            rounded(greatest->at->eps.value, decimals_for(greatest->at->eps)) + " (" + file_name(greatest->recording) +
            ", " + speed(greatest->at->v_mps) + "); ";
  return text + (differ ? "each has a value of its own, one for all of them would belong to no ball."
                        : "each has a value of its own (--pool makes one of all).");
}

/// "Dropped from about 5.2 cm (4.9 to 5.5 cm); from 52 impacts in 8.2 s."
std::string of_drops(const DropsSeen& seen, bool one_ball) {
  std::string text;
  if (seen.drop_height_m && one_ball) {
    const std::string of_drops = formatted("the %zu drops whose first impact was heard", seen.n_heights);
    const std::string remark = seen.n_drops == 1     ? ""
                               : seen.n_heights == 1 ? "of the one drop whose first impact was heard"
                                                     : "median of " + of_drops;
    text = "Dropped from " +
           (seen.drop_heights_m ? lengths(*seen.drop_heights_m) + " (" + of_drops + ")"
                                : height(*seen.drop_height_m, seen.drop_height_ci95_m, remark)) +
           "; ";
  }
  if (!seen.n_impacts) return text.empty() ? "" : text.substr(0, text.size() - 2) + ".";
  text += formatted("%s %zu impacts", text.empty() ? "From" : "from", *seen.n_impacts);
  if (seen.n_drops > 1) text += formatted(" in %zu drops", seen.n_drops);
  return text + (seen.n_drops > 1 ? ", " : " in ") + duration(*seen.duration_s) +
         (seen.n_drops > 1 ? " of bouncing." : ".");
}

/// Nothing fitted: what there is, and what is missing.
std::string of_missing(const FitResult& result, const RestitutionSamples& samples) {
  std::vector<double> eps;
  for (const RestitutionSample& s : samples)
    if (s.flags.empty() && std::isfinite(s.eps) && s.v_mps > 0.0) eps.push_back(s.eps);
  if (eps.empty()) return "ε is not known: no three impacts in a row from which it could be had.";
  return "ε cannot be stated: " + result.law.message + ".";
}

}  // namespace

std::string interval_in_words(const Estimate& e) {
  const int decimals = decimals_for(e);
  return rounded(e.ci95->lo, decimals) + " to " + rounded(e.ci95->hi, decimals);
}

std::string in_words(const KindsOfDrops& kinds) {
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(log10(kinds.eps_upper - kinds.eps_lower))), 2, 8);
  return formatted(
      "The drops are of two kinds: ε is about %.*f in %zu of them and about %.*f in %zu. Two balls, or two "
      "floors?",
      decimals, kinds.eps_lower, kinds.n_lower, decimals, kinds.eps_upper, kinds.n_upper);
}

const std::vector<NodeEstimate>& nodes_of(const FitResult& result, bool with_memory) {
  if (with_memory) return result.memory->nodes;
  return result.averaged ? result.averaged->nodes : result.law.nodes;
}

std::string in_words(const RecordingAnswer& recording) {
  const std::string name = file_name(recording.recording) + ": ";
  return recording.at ? name + "ε = " + with_interval(recording.at->eps) + " at " + speed(recording.at->v_mps)
                      : name + recording.missing;
}

PlainAnswer plain_answer(const FitResult& result, const RestitutionSamples& samples) {
  PlainAnswer answer;
  answer.seen = drops_seen(samples, heights_of(result));
  answer.recordings = answers_by_recording(result, samples);
  const bool is_fitted = usable(result) || result.averaged;
  const bool pooled = is_fitted && result.is_one_ball;
  if (pooled) {
    answer.with_memory = memory_holds(result);
    const auto& nodes = quoted_nodes(result);
    const Matrix correlation = quoted_law(result).node_correlation;
    const std::size_t middle = nodes.size() / 2;
    answer.at = at_node(nodes[middle], result.law);
    answer.one_value = nodes.size() == 1;
    for (const std::size_t k : {nodes.size() - 1, std::size_t{0}})
      if (differs(result, nodes, correlation, k)) answer.elsewhere.push_back(at_node(nodes[k], result.law));
    answer.sentences.push_back(of_value(answer, result));
    answer.doubt = largest_part(result, !samples.empty() && samples.front().conditions.ball);
    if (result.averaged && result.averaged->step)
      answer.sentences.push_back(of_step(*result.averaged->step, decimals_for(answer.at->eps)));
    if (answer.at->eps.value > 0.0 && answer.at->eps.value < 1.0)
      answer.sentences.push_back(percent_lost(*answer.at) +
                                 " % of the energy of its motion up and down is lost in each bounce" +
                                 " at that speed" + why_not_of_peak(*answer.at) + ".");
  } else {
    answer.sentences.push_back(
        !is_fitted ? of_missing(result, samples)
        : result.kinds_of_drops && !disagree(result.recordings)
            ? in_words(*result.kinds_of_drops) +
                  " Take them apart: one value for all would belong to no ball (--pool makes one)."
            : of_range(answer, disagree(result.recordings)));
  }
  if (std::string drops = of_drops(answer.seen, answer.recordings.empty()); !drops.empty())
    answer.sentences.push_back(std::move(drops));
  return answer;
}

}  // namespace bouncelab::report
