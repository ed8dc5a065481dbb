// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/detector_score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::loop {
namespace {

constexpr double kLargestOffset_s = 50e-3;

std::optional<double> ratio(double numerator, double denominator) {
  return denominator > 0.0 ? std::optional(numerator / denominator) : std::nullopt;
}

/// @param values  not empty
double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double median_size(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return median(std::move(values));
}

/// In order of time, each with its place in the table.
using Times = std::vector<std::pair<double, std::size_t>>;

Times in_order(const Onsets& onsets) {
  Times times;
  for (const Onset& onset : onsets) times.emplace_back(onset.t_s, times.size());
  std::sort(times.begin(), times.end());
  return times;
}

/// The most pairs of times within a tolerance, one to one: where the earlier of two has no partner that is not earlier
/// than the other's, taking pairs as they come loses none.
std::size_t most_pairs(const Times& truth, const Times& marked, double tolerance_s) {
  std::size_t n = 0, i = 0, j = 0;
  while (i < truth.size() && j < marked.size()) {
    const double late_s = marked[j].first - truth[i].first;
    if (std::abs(late_s) <= tolerance_s) ++n;
    if (late_s >= -tolerance_s) ++i;
    if (late_s <= tolerance_s) ++j;
  }
  return n;
}

struct Pair {
  double late_s = 0.0;  // marked less true time
  std::size_t truth = 0, mark = 0;
};

/// All that lie within a tolerance about an offset.
std::vector<Pair> pairs_within(const Times& truth, const Times& marked, double offset_s, double tolerance_s) {
  std::vector<Pair> pairs;
  auto first = marked.begin();
  for (const auto& [t_s, k] : truth) {
    while (first != marked.end() && first->first - offset_s < t_s - tolerance_s) ++first;
    for (auto it = first; it != marked.end() && it->first - offset_s <= t_s + tolerance_s; ++it)
      pairs.push_back({it->first - t_s, k, it->second});
  }
  return pairs;
}

/// Of these one to one, the nearest first.
std::vector<Pair> nearest_pairs(const Times& truth, const Times& marked, double offset_s, double tolerance_s) {
  std::vector<Pair> all = pairs_within(truth, marked, offset_s, tolerance_s), nearest;
  std::stable_sort(all.begin(), all.end(), [&](const Pair& a, const Pair& b) {
    return std::abs(a.late_s - offset_s) < std::abs(b.late_s - offset_s);
  });
  std::vector<bool> is_found(truth.size(), false), is_taken(marked.size(), false);
  for (const Pair& pair : all) {
    if (is_found[pair.truth] || is_taken[pair.mark]) continue;
    is_found[pair.truth] = is_taken[pair.mark] = true;
    nearest.push_back(pair);
  }
  return nearest;
}

std::vector<double> lateness_of(const std::vector<Pair>& pairs) {
  std::vector<double> late_s;
  for (const Pair& pair : pairs) late_s.push_back(pair.late_s);
  return late_s;
}

/// The latency at which most differences between marked and true times are within the tolerance.
double commonest_difference(const Times& truth, const Times& marked, double tolerance_s) {
  std::vector<double> differences = lateness_of(pairs_within(truth, marked, 0.0, kLargestOffset_s));
  std::sort(differences.begin(), differences.end());
  std::size_t first = 0, best_first = 0, most = 0;
  for (std::size_t last = 0; last < differences.size(); ++last) {
    while (differences[last] - differences[first] > 2.0 * tolerance_s) ++first;
    if (last + 1 - first > most) most = last + 1 - first, best_first = first;
  }
  return most == 0 ? 0.0 : differences[best_first + most / 2];
}

std::optional<double> offset_of(const Times& truth, const Times& marked) {
  const double tolerance_s = kTolerances_s[kJitterTolerance];
  double offset_s = commonest_difference(truth, marked, tolerance_s);
  constexpr int kRounds = 3;  // the median settles in one or two
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Pair> pairs = nearest_pairs(truth, marked, offset_s, tolerance_s);
    if (pairs.empty()) return std::nullopt;
    offset_s = median(lateness_of(pairs));
  }
  return offset_s;
}

/// What a + b v^(-1/5) leaves of the errors, with a constant a for each group, where far-off ones count less: weighted
/// least squares in turns with weights 1/sqrt(1 + (error / twice their typical size)^2).
/// @param scaling  v^(-1/5); empty: b is 0
/// @return empty where they leave fewer than two errors to themselves: what is fitted through is no jitter
std::vector<double> beyond_contact_law(const std::vector<double>& errors, const std::vector<double>& scaling,
                                       const std::vector<std::int64_t>& groups) {
  constexpr std::size_t kLeastFree = 2;
  const std::size_t n_constants = std::set<std::int64_t>(groups.begin(), groups.end()).size();
  if (errors.size() < n_constants + kLeastFree) return {};
  constexpr int kRounds = 20;
  constexpr double kLeast_s = 2e-15;  // so that nothing is divided by 0
  const bool has_law = !scaling.empty() && errors.size() > n_constants + kLeastFree;
  struct Means {
    double w = 0.0, u = 0.0, e = 0.0;
  };
  std::vector<double> rest = errors, weights(errors.size(), 1.0);
  for (int round = 0; round < kRounds; ++round) {
    std::map<std::int64_t, Means> means;
    for (std::size_t k = 0; k < errors.size(); ++k) {
      Means& m = means[groups[k]];
      const double weight = square(weights[k]);
      m.w += weight, m.u += has_law ? weight * scaling[k] : 0.0, m.e += weight * errors[k];
    }
    const auto off_mean = [&](std::size_t k) {
      const Means& m = means[groups[k]];
      return std::pair(has_law ? scaling[k] - m.u / m.w : 0.0, errors[k] - m.e / m.w);
    };
    double uu = 0.0, ue = 0.0;
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const auto [u, e] = off_mean(k);
      uu += square(weights[k]) * u * u, ue += square(weights[k]) * u * e;
    }
    const double slope = uu > 0.0 ? ue / uu : 0.0;
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const auto [u, e] = off_mean(k);
      rest[k] = e - slope * u;
    }
    const double size = kLeast_s + 2.0 * kSdOverMad * median_size(rest);
    for (std::size_t k = 0; k < errors.size(); ++k) weights[k] = 1.0 / std::sqrt(1.0 + square(rest[k] / size));
  }
  return rest;
}

/// True times of each drop that follow each other, in order of time.
std::map<std::int64_t, std::vector<std::size_t>> drops_of(const Onsets& truth) {
  std::map<std::int64_t, std::vector<std::size_t>> drops;
  for (const auto& [t_s, k] : in_order(truth)) drops[truth[k].drop].push_back(k);
  return drops;
}

/// @param error_s  of each true time that was found, less what is no error of an interval
void score_neighbours(const Onsets& truth, const Onsets& marked, const std::vector<std::optional<double>>& error_s,
                      DetectorScore& score) {
  const auto& matches = score.match;
  std::vector<double> eps_errors;
  for (const auto& [number, drop] : drops_of(truth)) {
    for (std::size_t k = 0; k + 1 < drop.size(); ++k) {
      const std::size_t a = drop[k], b = drop[k + 1];
      if (!matches[a] || !matches[b]) continue;
      const Onset &from = marked[*matches[a]], &to = marked[*matches[b]];
      if (k + 2 < drop.size() && matches[drop[k + 2]]) {
        const std::size_t c = drop[k + 2];
        eps_errors.push_back((marked[*matches[c]].t_s - to.t_s) / (to.t_s - from.t_s) -
                             (truth[c].t_s - truth[b].t_s) / (truth[b].t_s - truth[a].t_s));
      }
      if (!from.sigma_t_s || !to.sigma_t_s || !(*from.sigma_t_s > 0.0) || !(*to.sigma_t_s > 0.0)) continue;
      const double between_s = *error_s[b] - *error_s[a], sigma_s = std::hypot(*from.sigma_t_s, *to.sigma_t_s);
      const double pull = between_s / sigma_s;
      constexpr double kMostPull = 5.0;
      const double scored_s = std::max(sigma_s, std::abs(between_s) / kMostPull);
      ++score.n_stated;
      score.n_covered += std::abs(pull) <= kNormal95 ? 1 : 0;
      score.sum_pull2 += square(pull);
      score.largest_pull = std::max(score.largest_pull.value_or(0.0), std::abs(pull));
      score.sum_log_score -= log(scored_s / 1e-6) + 0.5 * square(between_s / scored_s);
    }
  }
  std::erase_if(eps_errors, [](double error) { return !std::isfinite(error); });  // two marks at one time
  if (!eps_errors.empty()) score.eps_error = root_mean_square(eps_errors);
}

void score_errors(const TrueTimes& truth, const Onsets& marked, DetectorScore& score) {
  std::vector<double> errors, scaling, bounds;
  std::vector<std::int64_t> drops;
  for (std::size_t k = 0; k < truth.onsets.size(); ++k) {
    if (!score.match[k]) continue;
    errors.push_back(marked[*score.match[k]].t_s - truth.onsets[k].t_s - *score.offset_s);
    drops.push_back(truth.onsets[k].drop);
    if (!truth.v_mps.empty()) scaling.push_back(pow(truth.v_mps[k], -0.2));
    if (truth.onsets[k].sigma_t_s) bounds.push_back(*truth.onsets[k].sigma_t_s);
  }
  const std::vector<double> within_drops = beyond_contact_law(errors, scaling, drops);
  if (constexpr std::size_t kLeastPairs = 3; errors.size() >= kLeastPairs) {  // of one or two, the offset takes all
    score.jitter_s = root_mean_square(errors);
    score.typical_s = kSdOverMad * median_size(errors);
    const std::vector<std::int64_t> one_group(errors.size(), 0);
    if (!scaling.empty()) score.within_law_s = root_mean_square(beyond_contact_law(errors, scaling, one_group));
    if (!within_drops.empty()) score.within_drops_s = root_mean_square(within_drops);
    if (bounds.size() == errors.size()) {
      score.bound_s = root_mean_square(bounds);
      score.bound_ratio = ratio(score.within_law_s.value_or(*score.jitter_s), *score.bound_s);
      if (score.within_drops_s) score.bound_ratio_within_drops = ratio(*score.within_drops_s, *score.bound_s);
    }
  }
  const std::vector<double>& rest = within_drops.empty() ? errors : within_drops;
  std::vector<std::optional<double>> error_of_each(truth.onsets.size());
  for (std::size_t k = 0, n = 0; k < truth.onsets.size(); ++k)
    if (score.match[k]) error_of_each[k] = rest[n++];
  score_neighbours(truth.onsets, marked, error_of_each, score);
}

std::optional<double> median_of(const std::vector<DetectorScore>& scores,
                                std::optional<double> DetectorScore::*member) {
  std::vector<double> values;
  for (const DetectorScore& score : scores)
    if (score.*member) values.push_back(*(score.*member));
  return values.empty() ? std::nullopt : std::optional(median(std::move(values)));
}

}  // namespace

std::vector<ColumnSpec> true_time_columns() {
  std::vector<ColumnSpec> columns = onset_columns();
  columns.push_back({"v_mps", ColumnType::real, false, positive_up_to(1e3)});
  columns.push_back({"travel_time_s", ColumnType::real, false, known({0.0, 1.0})});
  return columns;
}

TrueTimes true_times_from_table(const Table& table, const std::string& name) {
  TrueTimes truth{onsets_from_table(table, name)};
  if (const std::vector<double>* travel_s = table.reals("travel_time_s"))
    for (std::size_t k = 0; k < truth.onsets.size(); ++k) truth.onsets[k].t_s += (*travel_s)[k];
  const std::vector<double>* speeds = table.reals("v_mps");
  if (speeds != nullptr && std::none_of(speeds->begin(), speeds->end(), [](double v) { return std::isnan(v); }))
    truth.v_mps = *speeds;
  return truth;
}

std::optional<double> Agreement::precision() const {
  return ratio(static_cast<double>(n_found), static_cast<double>(n_marked));
}
std::optional<double> Agreement::recall() const {
  return ratio(static_cast<double>(n_found), static_cast<double>(n_true));
}
std::optional<double> Agreement::f_measure() const {
  return ratio(2.0 * static_cast<double>(n_found), static_cast<double>(n_true + n_marked));
}

std::optional<double> DetectorScore::pull() const {
  const std::optional<double> mean = ratio(sum_pull2, static_cast<double>(n_stated));
  return mean ? std::optional(std::sqrt(*mean)) : std::nullopt;
}
std::optional<double> DetectorScore::coverage() const {
  return ratio(static_cast<double>(n_covered), static_cast<double>(n_stated));
}
std::optional<double> DetectorScore::log_score() const { return ratio(sum_log_score, static_cast<double>(n_stated)); }
std::optional<double> DetectorScore::invented_per_hour() const {
  return ratio(3600.0 * static_cast<double>(n_invented), without_ball_s);
}
std::optional<double> DetectorScore::times_real_time() const { return ratio(duration_s, processor_s); }

DetectorScore score_detector(const TrueTimes& truth, const Onsets& marked, double duration_s, double processor_s) {
  DetectorScore score;
  score.duration_s = duration_s;
  score.processor_s = processor_s;
  for (Agreement& agreement : score.agreement) agreement = {truth.onsets.size(), marked.size(), 0};
  score.match.resize(truth.onsets.size());
  if (truth.onsets.empty()) {
    score.without_ball_s = duration_s;
    score.n_invented = marked.size();
    return score;
  }
  const Times true_s = in_order(truth.onsets), marked_s = in_order(marked);
  score.agreement[0].n_found = most_pairs(true_s, marked_s, kTolerances_s[0]);
  score.offset_s = offset_of(true_s, marked_s);
  if (!score.offset_s) return score;
  for (std::size_t k = 1; k < kTolerances_s.size(); ++k) {
    const std::vector<Pair> pairs = nearest_pairs(true_s, marked_s, *score.offset_s, kTolerances_s[k]);
    score.agreement[k].n_found = pairs.size();
    if (k != kJitterTolerance) continue;
    for (const Pair& pair : pairs) score.match[pair.truth] = pair.mark;
    score_errors(truth, marked, score);
  }
  return score;
}

DetectorScore pooled(const std::vector<DetectorScore>& scores) {
  DetectorScore all;
  all.n_recordings = 0;
  for (const DetectorScore& score : scores) {
    all.n_recordings += score.n_recordings;
    for (const std::optional<std::size_t>& mark : score.match)
      all.match.push_back(mark ? std::optional(all.agreement[0].n_marked + *mark) : std::nullopt);
    for (std::size_t k = 0; k < kTolerances_s.size(); ++k) {
      all.agreement[k].n_true += score.agreement[k].n_true;
      all.agreement[k].n_marked += score.agreement[k].n_marked;
      all.agreement[k].n_found += score.agreement[k].n_found;
    }
    all.n_stated += score.n_stated;
    all.n_covered += score.n_covered;
    all.sum_pull2 += score.sum_pull2;
    all.largest_pull = std::max(all.largest_pull, score.largest_pull);  // none is less than any
    all.sum_log_score += score.sum_log_score;
    all.without_ball_s += score.without_ball_s;
    all.n_invented += score.n_invented;
    all.duration_s += score.duration_s;
    all.processor_s += score.processor_s;
  }
  using S = DetectorScore;
  for (const auto member : {&S::offset_s, &S::jitter_s, &S::typical_s, &S::within_law_s, &S::within_drops_s,
                            &S::bound_s, &S::bound_ratio, &S::bound_ratio_within_drops, &S::eps_error})
    all.*member = median_of(scores, member);
  return all;
}

namespace {

template <std::size_t Tolerance, auto Measure>
constexpr Member agreement(std::string_view name, std::string_view text) {
  return computed(
      name, [](const DetectorScore& s) { return std::invoke(Measure, s.agreement[Tolerance]); }, text);
}

}  // namespace

Description members_of(const DetectorScore*) {
  using S = DetectorScore;
  static constexpr Member all[]{
      member<&S::n_recordings>("n_recordings", "Recordings"),
      computed(
          "n_true", [](const S& s) { return s.agreement[0].n_true; }, "True impacts"),
      computed(
          "n_marked", [](const S& s) { return s.agreement[0].n_marked; }, "Marks"),
      computed(
          "n_found", [](const S& s) { return s.agreement[kJitterTolerance].n_found; },
          "Pairs of both within 5 ms, one to one; the others are missed, and invented"),
      agreement<0, &Agreement::precision>("precision_50ms",
                                          "Share of the marks that lie within 50 ms of an impact of their own"),
      agreement<0, &Agreement::recall>("recall_50ms", "Share of the impacts that have such a mark"),
      agreement<0, &Agreement::f_measure>("f_50ms", "Harmonic mean of both"),
      agreement<1, &Agreement::precision>("precision_5ms",
                                          "Share of the marks that lie within 5 ms of an impact of their own"),
      agreement<1, &Agreement::recall>("recall_5ms", "Share of the impacts that have such a mark"),
      agreement<1, &Agreement::f_measure>("f_5ms", "Harmonic mean of both"),
      agreement<2, &Agreement::precision>("precision_1ms",
                                          "Share of the marks that lie within 1 ms of an impact of their own"),
      agreement<2, &Agreement::recall>("recall_1ms", "Share of the impacts that have such a mark"),
      agreement<2, &Agreement::f_measure>("f_1ms", "Harmonic mean of both"),
      agreement<3, &Agreement::precision>("precision_0.1ms",
                                          "Share of the marks that lie within 0.1 ms of an impact of their own"),
      agreement<3, &Agreement::recall>("recall_0.1ms", "Share of the impacts that have such a mark"),
      agreement<3, &Agreement::f_measure>("f_0.1ms", "Harmonic mean of both"),
      member<&S::offset_s>("offset_s", "Median of marked less true time, a latency, which cancels in intervals"),
      member<&S::jitter_s>(
          "jitter_s",
          "Root mean square of marked less true time, less the offset, of these pairs within 5 ms, three at least"),
      member<&S::typical_s>("typical_s",
                            "1.4826 times the median of their sizes: a standard deviation without outliers"),
      member<&S::within_law_s>(
          "within_law_s", "Root mean square less a + b v^(-1/5), the place in the contact at which an onset is marked"),
      member<&S::within_drops_s>("within_drops_s", "The same with a constant a for each drop"),
      member<&S::bound_s>("bound_s", "Root mean square of the Cramér-Rao bounds of the impacts found"),
      member<&S::bound_ratio>("bound_ratio", "`within_law_s`, else `jitter_s`, over the bound"),
      member<&S::bound_ratio_within_drops>("bound_ratio_within_drops", "`within_drops_s` over the bound"),
      member<&S::eps_error>("eps_error", "Root mean square error of ε of three neighbours found"),
      member<&S::n_stated>("n_stated", "Intervals of which both standard errors are stated"),
      member<&S::pull>("pull", "Root mean square of error over standard error: 1 where stated errors are right"),
      member<&S::largest_pull>("largest_pull", "The largest of these, of one interval: a rare wrong time shows here"),
      member<&S::coverage>("coverage", "Share of the 95 % intervals that hold the truth"),
      member<&S::log_score>(
          "log_score", "Mean of -ln(σ / 1 µs) - error²/(2 σ²): largest where errors are small and stated as they are"),
      member<&S::invented_per_hour>("invented_per_hour", "Marks in recordings without a ball, per hour"),
      member<&S::times_real_time>("times_real_time", "Length of the recordings over the detector's processor time")};
  return all;
}

}  // namespace bouncelab::loop
