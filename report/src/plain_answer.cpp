// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/recordings.hpp"
#include "words.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

SpeedAndRestitution at(double v_mps, const Estimate& eps) { return {v_mps, eps, 1.0 - square(eps.value)}; }

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

bool is_seen(const Estimate& change) {
  constexpr double kRounding = 1e-9;  // where a constant is likely, the interval ends at 0 but for rounding
  return change.ci95 && (change.ci95->lo > kRounding || change.ci95->hi < -kRounding);
}

/// Does the curve say otherwise than the name of the ball? Beyond three standard deviations, one answer in 300.
std::string contradicted(const Curve& curve) {
  constexpr double kBeyond = 3.0;
  const bool by_drag = curve.kappa_pull && std::abs(*curve.kappa_pull) > kBeyond;
  if (!by_drag && !(curve.contact_pull && std::abs(*curve.contact_pull) > kBeyond)) return "";
  const double pull = by_drag ? *curve.kappa_pull : *curve.contact_pull;
  return std::string("The bounces are not those of the ball that was named: ") +
         (by_drag ? (pull > 0.0 ? "the air slows this one more" : "the air slows this one less")
                  : (pull > 0.0 ? "this one touches the floor for a longer time"
                                : "this one touches the floor for a shorter time")) +
         formatted(" (by %.1f standard deviations). Another ball, or a time that is no impact?", std::abs(pull));
}

/// The speed of the node that most recordings reach; the middle one of equals.
std::optional<double> common_speed(const std::vector<RecordingFit>& rows) {
  std::map<double, std::size_t> n_at;
  for (const RecordingFit& row : rows)
    for (const CurveNode& node : row.nodes) ++n_at[node.v_mps];
  std::size_t most = 0;
  for (const auto& [v_mps, n] : n_at) most = std::max(most, n);
  std::vector<double> best;
  for (const auto& [v_mps, n] : n_at)
    if (n == most) best.push_back(v_mps);
  return best.empty() ? std::nullopt : std::optional(best[best.size() / 2]);
}

/// What the rows are called in sentences: plates by their names.
std::vector<std::string> names_of(const Recordings& recordings) {
  std::vector<std::string> names;
  for (const RecordingFit& row : recordings.rows) names.push_back(row.recording);
  if (recordings.plates.empty()) names = short_names(names);
  for (std::string& name : names) name = name.empty() ? "without name" : printable(name);
  return names;
}

/// "ε at 0.5 m/s runs from 0.91 (a.wav) to 0.93 (b.wav)"; of recordings that no two have a common speed of, offsets.
std::string extremes(const Recordings& recordings) {
  const std::vector<RecordingFit>& rows = recordings.rows;
  using ValueOf = std::pair<double, const RecordingFit*>;
  std::vector<ValueOf> values;
  std::string what = "the difference from the common curve";
  if (const auto v_mps = common_speed(rows)) {
    for (const RecordingFit& row : rows)
      for (const CurveNode& node : row.nodes)
        if (node.v_mps == *v_mps) values.emplace_back(node.eps.value, &row);
    if (values.size() > 1) what = formatted("ε at %.3g m/s", *v_mps);
  }
  if (values.size() < 2) {
    values.clear();
    for (const RecordingFit& row : rows)
      if (row.offset) values.emplace_back(row.offset->value, &row);
  }
  if (values.size() < 2) return {};
  const auto [least, greatest] = std::minmax_element(
      values.begin(), values.end(), [](const ValueOf& a, const ValueOf& b) { return a.first < b.first; });
  const std::vector<std::string> names = names_of(recordings);
  const auto in_brackets = [&](const ValueOf& value) {
    return formatted("%.4f (", value.first) + names[static_cast<std::size_t>(value.second - rows.data())] + ")";
  };
  return what + " runs from " + in_brackets(*least) + " to " + in_brackets(*greatest);
}

std::vector<ReleaseHeight> heights_of(const FitResult& result) {
  return result.curve ? result.curve->heights : std::vector<ReleaseHeight>{};
}

std::vector<RecordingAnswer> answers_by_recording(const FitResult& result, const RestitutionSamples& samples) {
  if (result.recordings.rows.empty()) return {};
  std::map<std::string, RestitutionSamples> of;
  for (auto& [name, of_row] : by_row(samples, result.recordings.plates)) of[name] = std::move(of_row);
  const std::optional<double> v_mps = common_speed(result.recordings.rows);
  const std::vector<std::string> names = names_of(result.recordings);
  std::vector<RecordingAnswer> answers;
  for (const RecordingFit& row : result.recordings.rows) {
    RecordingAnswer answer{row.recording,
                           names[answers.size()],
                           {},
                           row.nodes.empty() && row.law.why ? in_words(*row.law.why) : "",
                           drops_seen(of[row.recording], row.heights)};
    const CurveNode* nearest = nullptr;
    for (const CurveNode& node : row.nodes)
      if (!nearest || std::abs(node.v_mps - *v_mps) < std::abs(nearest->v_mps - *v_mps)) nearest = &node;
    if (nearest) answer.at = at(nearest->v_mps, nearest->eps);
    answers.push_back(std::move(answer));
  }
  return answers;
}

/// The middle one, or where eps steps near its speed one that lies beside the step.
const CurveNode& stated_node(const Curve& curve) {
  constexpr double kBeside = 0.2;  // in ln v
  const CurveNode* best = &curve.nodes[curve.nodes.size() / 2];
  if (!curve.step) return *best;
  const auto distance = [&](const CurveNode& node) { return std::abs(log(node.v_mps / curve.step->v_mps)); };
  if (distance(*best) > kBeside) return *best;
  for (const CurveNode& node : curve.nodes)
    if (distance(node) > distance(*best)) best = &node;
  return *best;
}

/// "ε steps from 0.92 to 0.85 (by 0.06 to 0.08) where the ball gets slower than 0.68 m/s, after bounce 17: did it reach
/// another surface?"
std::string of_step(const RestitutionStep& step, int decimals) {
  Estimate size = step.change;
  if (size.value < 0.0) size.ci95 = Interval{-size.ci95->hi, -size.ci95->lo};
  std::string text = "ε steps from " + rounded(step.eps_faster, decimals) + " to " +
                     rounded(step.eps_slower, decimals) + " (by " + interval_in_words(size) +
                     ") where the ball gets slower than " + speed(step.v_mps);
  if (step.impact) text += ", after bounce " + std::to_string(*step.impact + 1);
  return text + ": did it reach another surface?";
}

std::string of_value(const PlainAnswer& answer, const Curve& curve, const SampleConditions& conditions) {
  const SpeedAndRestitution& at = *answer.at;
  std::string text = "ε = " + with_interval(at.eps) + " at " + speed(at.v_mps);
  if (curve.n_drops == 1 && conditions.of_flights()) text += ", of this drop";
  std::string before = "; it ", said;
  for (const SpeedAndRestitution& other : answer.elsewhere) {
    const std::string verb = other.eps.value < at.eps.value ? "falls " : "rises ";
    text += before + (verb == said ? "" : verb) + "to " +
            rounded(other.eps.value, std::min(decimals_for(other.eps), decimals_for(at.eps))) + " at " +
            speed(other.v_mps);
    before = " and ", said = verb;
  }
  if (!answer.elsewhere.empty() || curve.points.empty() || curve.step) return text + ".";
  // a change that the bounces cannot exclude is not one that is not there
  constexpr double kShort = 1.0 / 3.0;
  double widest = 0.0;
  for (const Estimate& change : curve.end_changes) widest = std::max(widest, change.ci95->hi - change.ci95->lo);
  const std::string range = speed(curve.points.front().x) + " and " + speed(curve.points.back().x);
  if (widest < kShort * (1.0 - at.eps.value)) return text + "; no change with the speed is seen between " + range + ".";
  return text + (conditions.ball || !curve.kappa_per_m
                     ? "; whether ε changes between " + range + " is not known."
                     : std::string("; whether the speed or the air changes ε is not known from the ") +
                           measured_in_words(conditions) + ": name the ball (--ball).");
}

/// With one decimal where the standard error, 2 eps se, warrants it.
std::string percent_lost(const SpeedAndRestitution& at) {
  const bool exact = at.eps.se && 200.0 * at.eps.value * *at.eps.se < 0.5;
  return rounded(100.0 * at.energy_lost, exact ? 1 : 0);
}

const char* noun(const Recordings& recordings) { return !recordings.plates.empty() ? "plates" : "recordings"; }

/// Where recordings differ by more than chance, or cannot be compared: their range instead of a value.
std::string of_range(const Recordings& recordings) {
  if (const auto differ = note_of_difference(recordings)) return as_sentence(*differ);
  const std::string range = extremes(recordings);
  return formatted("Whether the %zu %s agree is not known, since each has too few bounces: ", recordings.rows.size(),
                   noun(recordings)) +
         range + (range.empty() ? "" : "; ") + "use the value of each (--pool makes one value of all).";
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

/// "Dropped from 254 cm this ball rebounds to 141 cm (95 %: 137 to 145 cm); the rule (ITF) asks for 135 to
/// 147 cm on concrete: within."
std::string of_rebound(const Rebound& rebound) {
  const Interval& ci95 = *rebound.height_m.ci95;
  const int decimals = std::clamp(decimals_of_two_digits(100.0 * (ci95.hi - ci95.lo)) - 1, 0, 2);
  const auto cm = [decimals](double height_m) { return rounded(100.0 * height_m, decimals); };
  const std::optional<bool> is_within = rebound.is_within();
  return "Dropped from " + formatted("%.4g", 100.0 * rebound.rule.height_m) + " cm this ball rebounds to " +
         cm(rebound.height_m.value) + " cm (95 %: " + cm(ci95.lo) + " to " + cm(ci95.hi) + " cm); the rule (" +
         rebound.rule.by + ") asks for " + asked_rebound(rebound.rule) + " on " + rebound.rule.floor + ": " +
         (!is_within   ? "whether it is within is not known, since the interval contains the limit."
          : *is_within ? "within."
                       : "not within.");
}

/// Does the ball that is named keep more than the best of its sport? They lose more the faster they are, and on any
/// other floor: only the least speed of the rule's test counts. Of quadratic drag k: v^2 = g (1 - exp(-2 k h))/k down
/// from h, u^2 = g (exp(2 k h) - 1)/k up to h.
std::string above_rule(const SpeedAndRestitution& at, const Curve& curve, const SampleConditions& conditions) {
  const ReboundRule* rule = conditions.ball ? rebound_rule(*conditions.ball) : nullptr;
  if (!rule || curve.rebound || !at.eps.ci95) return "";
  const double v_mps = std::sqrt(2.0 * conditions.gravity_mps2.value_or(kDefaultGravity_mps2) * rule->height_m);
  const double twice_k = curve.kappa_per_m ? 2.0 * curve.kappa_per_m->value : 0.0;
  const double greatest = twice_k > 0.0
                              ? std::sqrt(std::expm1(twice_k * rule->most_m) / -std::expm1(-twice_k * rule->height_m))
                              : std::sqrt(rule->most_m / rule->height_m);
  if (at.v_mps < v_mps || at.eps.ci95->lo <= greatest) return "";
  return "ε is above what the rule (" + rule->by + ") allows of such a ball, " + two_digits(greatest) + " at " +
         formatted("%.2g m/s", v_mps) + " on " + rule->floor + ". Is it another ball, or a " +
         (conditions.of_heights     ? "height"
          : conditions.of_flights() ? "time"
                                    : "speed") +
         " that is wrong?";
}

/// Nothing fitted: what there is, and what is missing.
std::string of_missing(const FitResult& result, const RestitutionSamples& samples) {
  std::vector<double> eps;
  for (const RestitutionSample& s : samples)
    if (s.flags.empty() && std::isfinite(s.eps) && s.v_mps > 0.0) eps.push_back(s.eps);
  if (eps.empty()) return "ε is not known: it needs at least three impacts in a row.";
  return "ε cannot be stated: " + (result.law.why ? in_words(*result.law.why) : "no law was fitted") + ".";
}

}  // namespace

std::string asked_rebound(const ReboundRule& rule) {
  return formatted("%.4g to %.4g cm", 100.0 * rule.least_m, 100.0 * rule.most_m);
}

std::string two_digits(double x) { return rounded(x, decimals_of_two_digits(x)); }

const char* measured_in_words(const SampleConditions& conditions) {
  return conditions.of_heights ? "heights" : conditions.of_flights() ? "times" : "speeds";
}

std::string interval_in_words(const Estimate& e) {
  const int decimals = decimals_for(e);
  return rounded(e.ci95->lo, decimals) + " to " + rounded(e.ci95->hi, decimals);
}

std::string in_words(const RecordingAnswer& recording) {
  return recording.name + ": " +
         (recording.at ? "ε = " + with_interval(recording.at->eps) + " at " + speed(recording.at->v_mps)
                       : recording.missing);
}

std::optional<Note> note_of_difference(const Recordings& recordings) {
  if (!disagree(recordings)) return std::nullopt;
  const RecordingsTest& test = *recordings.test;
  return Note{NoteKind::recordings_differ,
              {static_cast<double>(test.n_recordings), test.p_value, !recordings.plates.empty() ? 2.0 : 1.0},
              extremes(recordings)};
}

std::string in_words(const Recordings& recordings) {
  if (recordings.rows.empty()) return {};
  if (const auto differ = note_of_difference(recordings)) return in_words(*differ);
  if (!recordings.test)
    return formatted("the %zu %s cannot be compared: each has too few samples", recordings.rows.size(),
                     noun(recordings));
  const RecordingsTest& test = *recordings.test;
  return formatted("the %zu %s agree (p = %.2g", test.n_recordings, noun(recordings), test.p_value) +
         (test.within != WithinUnit::samples
              ? std::string(" by the differences between ") + to_string(test.within) + ")"
              : " if all impacts are independent; too few drops to know whether they are)");
}

PlainAnswer plain_answer(const FitResult& result, const RestitutionSamples& samples) {
  PlainAnswer answer;
  answer.seen = drops_seen(samples, heights_of(result));
  answer.recordings = answers_by_recording(result, samples);
  const bool is_fitted = result.curve.has_value();
  if (is_fitted && result.is_one_ball) {
    const Curve& curve = *result.curve;
    const CurveNode& node = stated_node(curve);
    answer.at = at(node.v_mps, node.eps);
    answer.one_value = curve.points.empty();
    // the fastest first: there most is lost
    if (!answer.one_value)
      for (const bool fastest : {true, false}) {
        const CurvePoint& end = fastest ? curve.points.back() : curve.points.front();
        Estimate eps;
        eps.value = end.y, eps.se = end.se, eps.ci95 = end.band95;
        if (is_seen(fastest ? curve.end_changes.back() : curve.end_changes.front()) && !curve.step)
          answer.elsewhere.push_back(at(end.x, eps));
      }
    const SampleConditions conditions = samples.empty() ? SampleConditions{} : samples.front().conditions;
    answer.sentences.push_back(of_value(answer, curve, conditions));
    if (curve.step) answer.sentences.push_back(of_step(*curve.step, decimals_for(answer.at->eps)));
    if (answer.at->eps.value > 0.0 && answer.at->eps.value < 1.0)
      answer.sentences.push_back(percent_lost(*answer.at) +
                                 " % of the energy of its motion up and down is lost in each bounce at that speed.");
    if (curve.rebound) answer.sentences.push_back(of_rebound(*curve.rebound));
    if (std::string above = above_rule(*answer.at, curve, conditions); !above.empty())
      answer.sentences.push_back(std::move(above));
    if (std::string other = contradicted(curve); !other.empty()) answer.sentences.push_back(std::move(other));
  } else {
    answer.sentences.push_back(
        !is_fitted ? of_missing(result, samples)
        : result.kinds_of_drops && !disagree(result.recordings)
            ? as_sentence(note_of(*result.kinds_of_drops)) +
                  " Take them apart: one value for all would belong to no ball (--pool makes one)."
            : of_range(result.recordings));
  }
  if (std::string drops = of_drops(answer.seen, answer.recordings.empty()); !drops.empty())
    answer.sentences.push_back(std::move(drops));
  return answer;
}

}  // namespace bouncelab::report
