// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "between/group_differences.hpp"
#include "between/offset_model.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// The model on the rows that are no outliers, and every row against it.
struct Judged {
  std::vector<Eigen::Index> kept;  ///< rows
  OffsetData data;                 ///< of these
  Deviations deviations{};
  std::vector<RecordingRow> rows;  ///< of all: standardised, p_value, is_outlier
};

constexpr double kLevel = 0.05;

/// Fits the rows that are not out, and judges all.
Judged judged(const OffsetData& data, const std::vector<bool>& out) {
  Judged result;
  for (Eigen::Index r = 0; r < data.n(); ++r)
    if (!out[static_cast<std::size_t>(r)]) result.kept.push_back(r);
  result.data = rows_of(data, result.kept);
  result.deviations = restricted_maximum(result.data);
  const OffsetSolution solution(result.data, result.deviations);
  const auto n = static_cast<double>(data.n());
  const ErrorsOfErrors errors(result.data, result.deviations);
  const double near = student_t_quantile(1.0 - 0.5 / n, 1e9);  // of so many rows one is so far off: p = 1
  Eigen::Index k = 0;
  for (Eigen::Index r = 0; r < data.n(); ++r) {
    const bool is_out = out[static_cast<std::size_t>(r)];
    const OffsetSolution::Residual residual =
        is_out ? solution.of_another(data.h().row(r), data.m()[r], data.variance[r], data.levels_of(r))
               : solution.without(k++);
    RecordingRow row;
    if (residual.se > 0.0) row.standardised = residual.value / residual.se;
    if (std::abs(row.standardised) > near) {
      const double n_free = errors.degrees_of_freedom_of_a_recording(residual.se);
      row.p_value = std::min(1.0, 2.0 * n * student_t_below(-std::abs(row.standardised), n_free));
    }
    row.is_outlier = is_out;
    result.rows.push_back(row);
  }
  return result;
}

/// The row furthest off among those that are in.
std::size_t furthest(const Judged& all, const std::vector<bool>& out) {
  std::size_t furthest = out.size();
  for (std::size_t r = 0; r < out.size(); ++r)
    if (!out[r] &&
        (furthest == out.size() || std::abs(all.rows[r].standardised) > std::abs(all.rows[furthest].standardised)))
      furthest = r;
  return furthest;
}

bool may_leave_out(const OffsetData& data, const std::vector<bool>& out) {
  std::vector<Eigen::Index> kept;
  for (std::size_t r = 0; r < out.size(); ++r)
    if (!out[r]) kept.push_back(static_cast<Eigen::Index>(r));
  return 4 * (out.size() - kept.size()) <= out.size() && static_cast<Eigen::Index>(kept.size()) > data.n_fixed() + 1 &&
         is_determined(rows_of(data, kept));
}

/// Outliers are rows whose distance from what the others predict, with the standard deviations of the others, has
/// p < 0.05 by Student's t after Bonferroni's correction for the number of rows. They are left out, and all are judged
/// anew, until none changes: rows beyond the level although they widen the standard deviations themselves at once, and
/// of the others that which is furthest off, by a fit without it. No more than a quarter of the rows become outliers.
Judged judge(const OffsetData& data) {
  constexpr int kMostRounds = 25;
  std::vector<bool> out(static_cast<std::size_t>(data.n()), false);
  Judged all = judged(data, out);
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<bool> next = out;
    for (std::size_t r = 0; r < out.size(); ++r) next[r] = all.rows[r].p_value < kLevel;
    if (!may_leave_out(data, next)) next = out;
    std::vector<bool> trial = next;
    const std::size_t worst = furthest(all, next);
    if (worst < trial.size()) trial[worst] = true;
    Judged without = trial != next && may_leave_out(data, trial) ? judged(data, trial) : Judged{};
    if (!without.rows.empty() && without.rows[worst].p_value < kLevel) {
      out = trial;
      all = std::move(without);
      continue;
    }
    if (next == out) break;
    out = next;
    all = judged(data, out);
  }
  return all;
}

/// The fitted model of one speed and what its errors are made of.
class Pool {
 public:
  Pool(const Design& design, const Judged& judged)
      : design_(design),
        judged_(judged),
        solution_(judged.data, judged.deviations),
        errors_(judged.data, judged.deviations) {
    const auto n_free = static_cast<double>(judged.data.n() - judged.data.n_fixed());
    if (n_free > 0.0) factor_ = std::max(1.0, solution_.sum_of_squares() / n_free);
  }

  const OffsetSolution& solution() const { return solution_; }
  /// Of direction' beta; with `more_variance` what is added to the error's square.
  Estimate estimate(double value, const Eigen::VectorXd& direction, double more_variance = 0.0) const {
    const double variance = factor_ * congruence(direction, solution_.covariance())(0, 0) + more_variance;
    const double se = std::sqrt(std::max(0.0, variance));
    const double n_free = errors_.degrees_of_freedom(direction, more_variance > 0.0 ? se : 0.0);
    return student_estimate(value, variance, n_free);
  }
  double eps() const { return design_.base + solution_.beta()[0]; }
  Estimate eps(double more_variance) const {
    return estimate(eps(), Eigen::VectorXd::Unit(judged_.data.n_fixed(), 0), more_variance);
  }
  /// Of one more recording as it is measured, on a plate and a day that may be any.
  double variance_of_a_recording() const {
    const Eigen::VectorXd& own = judged_.data.variance;
    double sum = median({own.begin(), own.end()});
    for (const double sd : judged_.deviations) sum += square(sd);
    return sum;
  }
  double degrees_of_freedom(const Eigen::VectorXd& direction) const { return errors_.degrees_of_freedom(direction); }
  double deviation_of_plates() const {
    return design_.plates.effect == GroupEffect::random ? judged_.deviations[design_.plate_grouping + 1] : 0.0;
  }
  double deviation_of_days() const {
    return design_.days.effect == GroupEffect::random ? judged_.deviations[design_.day_grouping + 1] : 0.0;
  }
  /// 1/variance of a row but for what its plate and day share.
  double weight(std::size_t k) const {
    return 1.0 / (square(judged_.deviations[0]) + judged_.data.variance[static_cast<Eigen::Index>(k)]);
  }
  /// eps of a plate in the middle of the campaign; absent where none of its recordings is here, or where plates and
  /// drift are one.
  std::optional<GroupRestitution> of_plate(const std::string& name) const;
  /// Of two plates that of_plate() has.
  DifferenceOfTwo difference(const std::string& first, const std::string& second) const;

 private:
  /// eps of a plate, or what two differ by. Of a plate that is a fixed effect all is in beta; else it is the mean of
  /// its recordings, which the drift of all takes to the middle of the campaign.
  struct OfPlates {
    std::size_t n = 0;  ///< recordings
    double value = 0.0;
    Eigen::VectorXd of_beta;
    double own_variance = 0.0;       ///< of the mean
    double error_of_one = 0.0;       ///< of a recording of that
    std::map<int, double> of_day{};  ///< shares of that
  };
  std::optional<OfPlates> mean_of_plate(const std::string& name) const;
  DifferenceOfTwo estimate(const OfPlates& of, double more_variance = 0.0) const;

  const Design& design_;
  const Judged& judged_;
  OffsetSolution solution_;
  ErrorsOfErrors errors_;
  double factor_ = 1.0;
};

std::optional<Pool::OfPlates> Pool::mean_of_plate(const std::string& name) const {
  const Eigen::Index n_fixed = judged_.data.n_fixed();
  const GroupLabels& plates = design_.plates;
  OfPlates of{0, 0.0, Eigen::VectorXd::Zero(n_fixed)};
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(n_fixed + 1);  // of the rows, and of their values last
  double weights = 0.0;
  int plate = -1;
  for (std::size_t k = 0; k < judged_.kept.size(); ++k) {
    const auto row = static_cast<std::size_t>(judged_.kept[k]);
    const int of_row = plates.of_recording[row];
    if (of_row < 0 || plates.names[static_cast<std::size_t>(of_row)] != name) continue;
    plate = of_row;
    mean += weight(k) * judged_.data.h_and_m.row(static_cast<Eigen::Index>(k));
    weights += weight(k);
    of.of_day[design_.days.of_recording[row]] += weight(k);
    ++of.n;
  }
  if (of.n == 0 || design_.plates_are_times) return std::nullopt;
  if (plates.effect == GroupEffect::fixed) {
    of.of_day.clear();
    of.of_beta = design_.of_plate(plate);
    of.value = design_.base + of.of_beta.dot(solution_.beta());
    return of;
  }
  mean /= weights;
  for (auto& [day, share] : of.of_day) share /= weights;
  if (design_.has_drift) of.of_beta[n_fixed - 1] = -mean[n_fixed - 1];  // from the mean of the recordings to the middle
  of.value = design_.base + mean[n_fixed] + of.of_beta.dot(solution_.beta());
  of.own_variance = 1.0 / weights;
  of.error_of_one = std::sqrt(static_cast<double>(of.n) / weights);
  return of;
}

DifferenceOfTwo Pool::estimate(const OfPlates& of, double more_variance) const {
  double variance = factor_ * congruence(of.of_beta, solution_.covariance())(0, 0) + of.own_variance + more_variance;
  for (const auto& [day, share] : of.of_day) variance += square(deviation_of_days() * share);
  const double n_free = of.own_variance > 0.0
                            ? errors_.degrees_of_freedom_of_a_recording(of.error_of_one)
                            : errors_.degrees_of_freedom(of.of_beta, more_variance > 0.0 ? std::sqrt(variance) : 0.0);
  return {student_estimate(of.value, variance, n_free), n_free};
}

std::optional<GroupRestitution> Pool::of_plate(const std::string& name) const {
  const std::optional<OfPlates> of = mean_of_plate(name);
  if (!of) return std::nullopt;
  const double of_another = variance_of_a_recording() - square(deviation_of_plates());
  return GroupRestitution{name, of->n, design_.v_mps, estimate(*of).eps, estimate(*of, of_another).eps.ci95, {}};
}

DifferenceOfTwo Pool::difference(const std::string& first, const std::string& second) const {
  const OfPlates reference = mean_of_plate(first).value();
  OfPlates of = mean_of_plate(second).value();
  of.value -= reference.value;
  of.of_beta -= reference.of_beta;
  of.own_variance += reference.own_variance;
  of.error_of_one = hypot(of.error_of_one, reference.error_of_one) / std::sqrt(2.0);
  for (const auto& [day, share] : reference.of_day) of.of_day[day] -= share;
  return estimate(of);
}

void describe_deviations(BetweenRecordings& result, const Design& design, const Judged& judged) {
  const auto deviation = [&](std::size_t k) {
    return StandardDeviation{judged.deviations[k], profile_interval(judged.data, judged.deviations, k)};
  };
  result.tau = deviation(0);
  result.plates.effect = design.plates.effect;
  result.days.effect = design.days.effect;
  if (design.plates.effect == GroupEffect::random) result.plates.deviation = deviation(design.plate_grouping + 1);
  if (design.days.effect == GroupEffect::random) result.days.deviation = deviation(design.day_grouping + 1);
}

/// Of all rows, by one eps without drift, groups and tau.
ChiSquareTest heterogeneity_of(const Design& design) {
  OffsetData data = design.data;
  OffsetData::Rows of_eps(data.n(), 2);
  of_eps << data.h().leftCols(1), data.m();
  data.h_and_m = of_eps;
  data.n_levels = {0, 0};
  const OffsetSolution solution(data, {0.0, 0.0, 0.0});
  ChiSquareTest test;
  test.chi2 = std::max(0.0, solution.sum_of_squares());
  test.ndf = static_cast<double>(data.n() - 1);
  test.p_value = chi2_survival(test.chi2, test.ndf);
  return test;
}

void describe_drift(BetweenRecordings& result, const Design& design, const Pool& pool, const Drift& times) {
  if (!design.has_drift) return;
  Drift drift = times;
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(design.data.n_fixed());
  direction[direction.size() - 1] = 1.0 / (times.end - times.begin);
  drift.slope = pool.estimate(pool.solution().beta().dot(direction), direction);
  const double t = drift.slope.value / *drift.slope.se;
  drift.p_value = 2.0 * student_t_below(-std::abs(t), pool.degrees_of_freedom(direction));
  result.drift = drift;
}

/// Weighted means of what is left of the offsets by day.
void describe_days(BetweenRecordings& result, const Design& design, const Judged& judged, const Pool& pool) {
  const Eigen::VectorXd& beta = pool.solution().beta();
  const std::vector<std::string>& names = design.days.names;
  std::vector<GroupRow>& rows = result.days.rows;
  for (const std::string& name : names) rows.push_back({name});
  std::vector<double> weights(names.size(), 0.0);
  for (std::size_t k = 0; k < judged.kept.size(); ++k) {
    const auto row = static_cast<std::size_t>(judged.kept[k]);
    const int day = design.days.of_recording[row], plate = design.plates.of_recording[row];
    if (day < 0) continue;
    double left = judged.data.m()[static_cast<Eigen::Index>(k)] - design.of_plate(plate).dot(beta);
    if (design.plates.effect == GroupEffect::random) left -= pool.solution().effect(design.plate_grouping, plate);
    const auto d = static_cast<std::size_t>(day);
    ++rows[d].n;
    rows[d].offset += pool.weight(k) * left;
    weights[d] += pool.weight(k);
  }
  for (std::size_t d = 0; d < rows.size(); ++d) {
    rows[d].offset /= std::max(weights[d], 1e-300);
    rows[d].se = 1.0 / std::sqrt(weights[d]);
  }
  std::erase_if(rows, [](const GroupRow& row) { return row.n == 0; });
}

/// Bartlett, Proc. R. Soc. A 160, 268 (1937), doi:10.1098/rspa.1937.0109.
std::optional<UnequalScatter> unequal_scatter(const Design& design, const Judged& judged) {
  constexpr double kUnlikely = 0.01;
  constexpr std::size_t kFewestOfPlate = 4;
  constexpr double kNone = 1e-12;  // of the square of the length of the campaign
  // of each plate; one outlier is a bad recording, several are how a plate scatters
  std::vector<std::vector<Eigen::Index>> rows(design.plates.names.size()), outliers(rows.size());
  for (std::size_t r = 0; r < judged.rows.size(); ++r)
    if (const int plate = design.plates.of_recording[r]; plate >= 0)
      (judged.rows[r].is_outlier ? outliers : rows)[static_cast<std::size_t>(plate)].push_back(
          static_cast<Eigen::Index>(r));
  for (std::size_t p = 0; p < rows.size(); ++p)
    if (outliers[p].size() > 1) rows[p].insert(rows[p].end(), outliers[p].begin(), outliers[p].end());
  double n_plates = 0.0, n_free = 0.0, squares = 0.0, logs = 0.0, inverses = 0.0;
  UnequalScatter found;
  double most = -1.0, least = HUGE_VAL;
  for (std::size_t p = 0; p < rows.size(); ++p) {
    if (rows[p].size() < kFewestOfPlate) continue;
    // about a straight line of its own: the drift of all has the scatter of the widest
    const auto n = static_cast<Eigen::Index>(rows[p].size());
    const Eigen::ArrayXd weight = (design.data.variance(rows[p]).array() + square(judged.deviations[0])).inverse();
    const double weights = weight.sum();
    Eigen::ArrayXd value = design.data.m()(rows[p]), time = Eigen::ArrayXd::Zero(n);
    if (design.has_drift) time = design.data.h().col(design.data.n_fixed() - 1)(rows[p]);
    value -= (weight * value).sum() / weights;
    time -= (weight * time).sum() / weights;
    const double of_time = (weight * time.square()).sum();
    if (of_time > kNone * weights) value -= time * ((weight * time * value).sum() / of_time);
    const double own = (weight * value.square()).sum();
    const auto free = static_cast<double>(n - (of_time > kNone * weights ? 2 : 1));
    const double variance = std::max(own / free, 1e-12);
    const double sd = std::sqrt(variance * static_cast<double>(rows[p].size()) / weights);
    ++n_plates, n_free += free, squares += own, logs += free * log(variance), inverses += 1.0 / free;
    if (variance > most) most = variance, found.widest = design.plates.names[p], found.sd_widest = sd;
    if (variance < least) least = variance, found.narrowest = design.plates.names[p], found.sd_narrowest = sd;
  }
  if (n_plates < 2.0) return std::nullopt;
  const double correction = 1.0 + (inverses - 1.0 / n_free) / (3.0 * (n_plates - 1.0));
  const double chi2 = (n_free * log(std::max(squares / n_free, 1e-12)) - logs) / correction;
  found.p_value = chi2_survival(std::max(0.0, chi2), n_plates - 1.0);
  return found.p_value < kUnlikely ? std::optional(found) : std::nullopt;
}

void describe_rows(BetweenRecordings& result, const Design& design, const Judged& judged, const Pool& pool) {
  for (std::size_t k = 0; k < design.of_row.size(); ++k) {
    const auto r = static_cast<Eigen::Index>(k);
    RecordingRow& row = result.rows[design.of_row[k]];
    row = judged.rows[k];
    row.eps = design.base + design.data.m()[r];
    row.se = std::sqrt(design.data.variance[r]);
    row.offset = row.eps - pool.eps();
    result.n_outliers += row.is_outlier;
  }
}

/// How many recordings reach each speed.
std::map<double, std::size_t> reached_speeds(const std::vector<CampaignRecording>& recordings,
                                             const std::vector<std::size_t>& used) {
  std::map<double, std::size_t> n;
  for (const std::size_t k : used)
    for (const NodeEstimate& node : recordings[k].summary.nodes) ++n[node.v_mps];
  return n;
}

/// What most recordings reach, and of several speeds the middle one.
double reference_speed(const std::map<double, std::size_t>& reached) {
  std::size_t most = 0;
  std::vector<double> speeds;
  for (const auto& [v_mps, n] : reached) {
    if (n > most) speeds.clear(), most = n;
    if (n == most) speeds.push_back(v_mps);
  }
  return speeds[speeds.size() / 2];
}

/// eps of all and of the plates at each speed, of the recordings that are no outliers.
void describe_nodes(BetweenRecordings& result, const std::vector<CampaignRecording>& recordings,
                    const std::vector<std::size_t>& used, const CampaignTimes& times) {
  std::vector<std::size_t> kept;
  for (const std::size_t k : used)
    if (!result.rows[k].is_outlier) kept.push_back(k);
  const std::map<double, std::size_t> reached = reached_speeds(recordings, kept);
  const std::size_t fewest = std::max(kFewestPooled, (reached.at(result.v_mps) + 1) / 2);
  for (const auto& [v_mps, n] : reached) {
    if (n < fewest) continue;
    const Design design = make_design(recordings, kept, times, v_mps);
    if (design.data.n() <= design.data.n_fixed()) continue;
    const Judged judged = fit::judged(design.data, std::vector<bool>(n, false));
    const Pool pool(design, judged);
    result.nodes.push_back({v_mps, n, pool.eps(0.0), *pool.eps(pool.variance_of_a_recording()).ci95});
    if (!result.differences) continue;
    for (GroupRestitution& group : result.differences->groups)
      if (const auto here = pool.of_plate(group.name)) group.nodes.push_back({v_mps, here->eps});
    for (GroupDifference& row : result.differences->rows)
      if (pool.of_plate(row.reference) && pool.of_plate(row.group))
        row.nodes.push_back({v_mps, pool.difference(row.reference, row.group).eps});
  }
}

}  // namespace

const char* to_string(GroupEffect effect) {
  constexpr const char* kWords[]{"none", "fixed", "random"};
  return kWords[static_cast<std::size_t>(effect)];
}

BetweenRecordings compare_campaign(const std::vector<CampaignRecording>& recordings) {
  BetweenRecordings result;
  result.n_recordings = recordings.size();
  result.rows.resize(recordings.size());
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    result.rows[k].why_not = recordings[k].summary.why;
    if (recordings[k].summary.status == FitStatus::ok) used.push_back(k);
  }
  const std::map<double, std::size_t> reached = reached_speeds(recordings, used);
  if (!reached.empty()) {
    result.v_mps = reference_speed(reached);
    for (const std::size_t k : used)
      if (!eps_at(recordings[k].summary, result.v_mps))
        result.rows[k].why_not =
            Note{NoteKind::speed_not_reached,
                 {result.v_mps, recordings[k].summary.nodes.front().v_mps, recordings[k].summary.nodes.back().v_mps}};
    std::erase_if(used, [&](std::size_t k) { return result.rows[k].why_not.has_value(); });
  }
  result.n_used = used.size();
  for (const std::size_t k : used) result.n_samples += recordings[k].summary.n;
  if (result.n_used < kFewestPooled) {
    result.why = Note{NoteKind::too_few_recordings,
                      {static_cast<double>(result.n_used), static_cast<double>(result.n_recordings),
                       static_cast<double>(kFewestPooled)}};
    return result;
  }
  const CampaignTimes times = times_of(recordings, used);
  const Design design = make_design(recordings, used, times, result.v_mps);
  const Judged judged = judge(design.data);
  const Pool pool(design, judged);
  result.status = FitStatus::ok;
  result.notes = times.notes;
  result.notes.insert(result.notes.end(), design.notes.begin(), design.notes.end());
  result.eps = pool.eps(0.0);
  result.prediction95 = *pool.eps(pool.variance_of_a_recording()).ci95;
  result.heterogeneity = heterogeneity_of(design);
  describe_deviations(result, design, judged);
  describe_drift(result, design, pool, times.drift);
  describe_days(result, design, judged, pool);
  describe_rows(result, design, judged, pool);
  result.unequal_scatter = unequal_scatter(design, judged);
  GroupDifferences plates;
  plates.unit = GroupUnit::recordings;
  for (const std::string& name : design.plates.names) {
    auto group = pool.of_plate(name);
    if (!group) continue;
    result.plates.rows.push_back({name, group->n, group->eps.value - result.eps.value, *group->eps.se});
    plates.groups.push_back(*std::move(group));
  }
  if (design.plates.effect != GroupEffect::none && plates.groups.size() > 1) {
    add_pairs(plates, [&](std::size_t i, std::size_t j) {
      return pool.difference(plates.groups[i].name, plates.groups[j].name);
    });
    result.differences = std::move(plates);
  }
  describe_nodes(result, recordings, used, times);
  return result;
}

}  // namespace bouncelab::fit
