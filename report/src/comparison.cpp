// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/answer.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/text.hpp"
#include "words.hpp"

namespace bouncelab::report {

using namespace fit;

namespace {

/// What a recording is called in a list, and what else is said of it there.
Object row_of(const CampaignRecording& recording, const Object& more) {
  const RecordingOrigin& origin = recording.origin;
  Object row{{"recording", recording.summary.recording},
             {"plate", origin.plate},
             {"day", origin.date ? Value(origin.date->day) : Value{}},
             {"n", value_of(recording.summary.n)}};
  append(row, more);
  return row;
}

}  // namespace

Object object_of(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  Object all{{"status", to_string(between.status)},
             {"message", between.why ? in_words(*between.why) : std::string()},
             {"answer", value_of(in_words(between, recordings))}};
  all.emplace_back("notes", values_of(between.notes));
  append(all, bouncelab::object_of(between));
  Values outliers, not_used;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const RecordingRow& row = between.rows[k];
    if (row.is_outlier)
      outliers.push_back(row_of(recordings[k], {{"eps", row.eps},
                                                {"se", row.se},
                                                {"offset", row.offset},
                                                {"standardised", row.standardised},
                                                {"p_value", row.p_value}}));
    if (row.why_not)
      not_used.push_back(row_of(
          recordings[k], {{"status", to_string(recordings[k].summary.status)}, {"message", in_words(*row.why_not)}}));
  }
  all.emplace_back("outliers", std::move(outliers));
  all.emplace_back("not_used", std::move(not_used));
  return all;
}

std::string points_json(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings,
                        std::size_t most) {
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < recordings.size(); ++k)
    if (!between.rows[k].why_not) used.push_back(k);
  const bool by_date = between.drift && between.drift->by_date;
  const auto time = [&](std::size_t k) {
    const auto& date = recordings[k].origin.date;
    return by_date ? (date ? date->day : between.drift->middle) : static_cast<double>(k);
  };
  std::stable_sort(used.begin(), used.end(), [&](std::size_t a, std::size_t b) { return time(a) < time(b); });
  const std::size_t step = most > 0 ? (used.size() + most - 1) / most : 1;
  std::vector<std::size_t> shown;
  for (std::size_t j = 0; j < used.size(); ++j)
    if (between.rows[used[j]].is_outlier || j % step == 0) shown.push_back(used[j]);
  const auto column = [&](const auto& of) {
    std::vector<std::remove_cvref_t<decltype(of(0))>> cells;
    for (const std::size_t k : shown) cells.push_back(of(k));
    return cells;
  };
  const auto rounded = [&](double RecordingRow::*value, double steps) {  // far below any error
    return column([&](std::size_t k) { return std::round(between.rows[k].*value * steps) / steps; });
  };
  return json_text(Object{
      {"n", value_of(used.size())},
      {"recording", column([&](std::size_t k) { return recordings[k].summary.recording; })},
      {"plate", column([&](std::size_t k) { return recordings[k].origin.plate; })},
      {"time", column([&](std::size_t k) { return !by_date || recordings[k].origin.date ? time(k) : std::nan(""); })},
      {"n_samples", column([&](std::size_t k) { return static_cast<std::int64_t>(recordings[k].summary.n); })},
      {"eps", rounded(&RecordingRow::eps, 1e8)},
      {"se", rounded(&RecordingRow::se, 1e8)},
      {"offset", rounded(&RecordingRow::offset, 1e8)},
      {"standardised", rounded(&RecordingRow::standardised, 1e3)},
      {"outlier", column([&](std::size_t k) { return std::int64_t{between.rows[k].is_outlier}; })}});
}

namespace {

constexpr double kUnlikely = 0.05;

std::string n_recordings(std::size_t n) { return std::to_string(n) + (n == 1 ? " recording" : " recordings"); }

/// Values between 0 and 1 have no standard deviation above this: an interval that reaches beyond it knows nothing.
constexpr double kMostDeviation = 0.5;
std::string of_deviation(const StandardDeviation& sd, const char* name, const char* beyond) {
  const std::string differs = std::string("from ") + name + " to " + name;
  if (!(sd.ci95.hi < kMostDeviation))
    return "How much ε differs " + differs + " is not known: there are too few of them.";
  if (sd.ci95.hi < kLeastDeviation) return "No difference of ε " + differs + beyond + " is seen.";
  if (sd.value > kLeastDeviation && sd.ci95.lo > kLeastDeviation)
    return "ε differs " + differs +
           formatted(" by %.2g (standard deviation; 95 %%: %.2g to %.2g)", sd.value, sd.ci95.lo, sd.ci95.hi) + beyond +
           ".";
  return "No difference of ε " + differs + beyond +
         formatted(" is seen; it is at most %.2g (standard deviation, 95 %%).", sd.ci95.hi);
}

/// "95 %: 0.01 to 0.03"
std::string interval_known(const Estimate& e) {
  const bool is_known = e.ci95->hi - e.ci95->lo < 2.0;  // all that two values of ε can differ by
  return is_known ? "95 %: " + interval_in_words(e) : "its error is not known: there are too few drops";
}

/// "glass: ε = 0.98000 ± 0.00013 at 0.6 m/s; one more recording would have 0.9792 to 0.9808 (95 %)."
std::string eps_in_words(const std::string& of, const Estimate& eps, double v_mps, const std::string& over,
                         const std::optional<Interval>& next, const char* one) {
  return of + formatted("ε = %s at %.3g m/s", fit::in_words(eps.value, eps.se).c_str(), v_mps) + over +
         (!next ? "."
          : next->hi - next->lo < 1.0
              ? formatted("; one more %s would have %.5f to %.5f (95 %%).", one, next->lo, next->hi)
              : formatted("; what one more %s would have is not known.", one));
}

/// ε of each group; of many the greatest and the least.
std::vector<std::string> of_groups(std::vector<GroupRestitution> groups, const char* one) {
  constexpr std::size_t kMostNamed = 4;
  const std::size_t n = groups.size();
  std::vector<std::string> sentences;
  if (n > kMostNamed) {
    std::stable_sort(groups.begin(), groups.end(),
                     [](const auto& a, const auto& b) { return a.eps.value > b.eps.value; });
    groups = {groups.front(), groups.back()};
    sentences.push_back(
        formatted("Each of the %zu plates has its own ε, which comparison.csv states; the greatest and the least:", n));
  }
  for (const GroupRestitution& g : groups)
    sentences.push_back(eps_in_words(printable(g.name) + ": ", g.eps, g.v_mps,
                                     formatted(" over %zu %s%s", g.n, one, g.n == 1 ? "" : "s"), g.prediction95, one));
  return sentences;
}

std::string p_in_words(double p) { return p < 0.0001 ? "p < 0.0001" : formatted("p = %.2g", p); }

std::string of_drift(const BetweenRecordings& between) {
  constexpr const char* kTooFew = "Whether ε drifts is not known: there are too few recordings.";
  if (std::any_of(between.notes.begin(), between.notes.end(),
                  [](const Note& note) { return note.kind == NoteKind::one_date; }))
    return "A drift cannot be seen: all recordings have the same date.";
  if (!between.drift) return kTooFew;
  const Drift& drift = *between.drift;
  const std::string unit = drift.by_date ? "day" : "recording";
  const double length = drift.end - drift.begin;
  if (!(drift.slope.se.value_or(0.0) * length < kMostDeviation)) return kTooFew;
  const std::string slope = formatted(
      "%s a %s, %+.2g over %.*f %ss; %s", fit::in_words(drift.slope.value, drift.slope.se).c_str(), unit.c_str(),
      drift.slope.value * length, length < 10.0 ? 1 : 0, length, unit.c_str(), p_in_words(drift.p_value).c_str());
  if (drift.p_value < kUnlikely)
    return (drift.slope.value > 0.0 ? "ε rises over the campaign: " : "ε falls over the campaign: ") + slope + ".";
  return "No drift is seen: " + slope + ".";
}

std::string of_outliers(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  constexpr std::size_t kMostNamed = 5;
  std::vector<std::size_t> outliers;  // furthest first
  for (std::size_t k = 0; k < between.rows.size(); ++k)
    if (between.rows[k].is_outlier) outliers.push_back(k);
  std::stable_sort(outliers.begin(), outliers.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(between.rows[a].standardised) > std::abs(between.rows[b].standardised);
  });
  if (outliers.empty()) return "No recording stands out from the others by more than chance.";
  std::string text = n_recordings(outliers.size()) + (outliers.size() == 1 ? " stands" : " stand") +
                     " out from the others by more than chance and " + (outliers.size() == 1 ? "is" : "are") +
                     " left out of ε: ";
  for (std::size_t k = 0; k < std::min(outliers.size(), kMostNamed); ++k) {
    const RecordingRow& row = between.rows[outliers[k]];
    text += (k > 0 ? ", " : "") + printable(recordings[outliers[k]].summary.recording) +
            formatted(" (ε = %.5f, %+.1f standard deviations)", row.eps, row.standardised);
  }
  if (outliers.size() > kMostNamed) text += " and " + std::to_string(outliers.size() - kMostNamed) + " more";
  return text + ".";
}

/// " at 0.5 m/s", and where there are more speeds the ends: ", 0.018 at 0.2 m/s and 0.030 at 1 m/s".
std::string at_the_speeds(const GroupDifference& row, double sign) {
  std::string text = formatted(" at %.3g m/s", row.v_mps);
  if (row.nodes.size() < 3) return text;
  for (const auto& [joint, node] : {std::pair{", ", &row.nodes.front()}, {" and ", &row.nodes.back()}})
    text += joint + formatted("%.2g at %.3g m/s", sign * node->eps.value, node->v_mps);
  return text;
}

/// "glass and wood differ by more than drops of one plate do.", by what, and what could have been seen
std::vector<std::string> of_difference(const GroupDifference& row, GroupUnit unit, bool are_plates) {
  const std::string &a = row.reference, &b = row.group;
  const bool is_greater = row.eps.value > 0.0;
  Estimate size = row.eps;
  size.value = std::abs(size.value);
  if (!is_greater) size.ci95 = {-row.eps.ci95->hi, -row.eps.ci95->lo};
  const std::string higher = "ε of " + printable(b) + " is " + fit::in_words(size.value, size.se) + " (" +
                             interval_known(size) + (is_greater ? ") above" : ") below") + " that of " + printable(a) +
                             at_the_speeds(row, is_greater ? 1.0 : -1.0);
  const std::string of_one = std::string(to_string(unit)) + (are_plates ? " of one plate" : " of one recording");
  if (!row.p_value)
    return {higher + ".", "Whether " + of_one +
                              " differ as much is not known: there is one each; drop the ball several "
                              "times on each."};
  const std::string differ = printable(a) + " and " + printable(b) + " differ by more than " + of_one + " do (" +
                             p_in_words(*row.p_value) + ").";
  if (*row.p_value < kUnlikely) return {differ, higher + "."};
  return {"It is not seen that " + differ,
          higher +
              (row.detectable < 1.0
                   ? formatted("; a difference of %.2g would be seen in four of five such experiments.", row.detectable)
                   : "; no difference could be seen by so few drops: drop the ball more often on each.")};
}

}  // namespace

std::vector<std::string> in_words(const BetweenRecordings& between, const std::vector<CampaignRecording>& recordings) {
  std::vector<std::string> sentences;
  const auto& differences = between.differences;
  const char* const one = differences && differences->unit == GroupUnit::drops ? "drop" : "recording";
  if (differences) {
    const bool are_plates = std::any_of(recordings.begin(), recordings.end(),
                                        [](const CampaignRecording& r) { return !r.origin.plate.empty(); });
    for (const GroupDifference& row : differences->rows)
      for (std::string& sentence : of_difference(row, differences->unit, are_plates))
        sentences.push_back(std::move(sentence));
    if (differences->why) sentences.push_back("No difference is stated: " + in_words(*differences->why) + ".");
  }
  if (between.groups_differ())
    for (std::string& sentence : of_groups(differences->groups, one)) sentences.push_back(std::move(sentence));
  if (between.status != FitStatus::ok) return sentences.empty() ? std::vector{as_sentence(*between.why)} : sentences;
  if (!between.groups_differ())
    sentences.push_back(eps_in_words("", between.eps, between.v_mps,
                                     " over " + n_recordings(between.n_used - between.n_outliers), between.prediction95,
                                     "recording"));
  sentences.push_back(of_deviation(between.tau, "recording", " beyond the errors of each"));
  if (const auto& unequal = between.unequal_scatter)
    sentences.push_back(
        formatted("Recordings of %s scatter more than those of %s (standard deviations %.2g and %.2g; %s): one for all "
                  "is too little for the one and too much for the other; compare each plate alone.",
                  printable(unequal->widest).c_str(), printable(unequal->narrowest).c_str(), unequal->sd_widest,
                  unequal->sd_narrowest, p_in_words(unequal->p_value).c_str()));
  sentences.push_back(of_drift(between));
  sentences.push_back(of_outliers(between, recordings));
  for (const auto& [grouping, name] : {std::pair{&between.plates, "plate"}, {&between.days, "day"}})
    if (grouping->deviation) sentences.push_back(of_deviation(*grouping->deviation, name, ""));
  if (between.n_used < between.n_recordings)
    sentences.push_back(n_recordings(between.n_recordings - between.n_used) +
                        " could not be used; the table says why.");
  return sentences;
}

}  // namespace bouncelab::report
