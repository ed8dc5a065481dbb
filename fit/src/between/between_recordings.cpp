// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

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

/// The fitted model and what its errors are made of.
class Pool {
 public:
  Pool(const Design& design, const Judged& judged)
      : design_(design),
        judged_(judged),
        solution_(judged.data, judged.deviations),
        errors_(judged.data, judged.deviations) {
    const double n_free = static_cast<double>(judged.data.n() - judged.data.n_fixed()) + design.within_rank;
    if (n_free > 0.0) factor_ = std::max(1.0, solution_.sum_of_squares() / n_free);
  }

  const OffsetSolution& solution() const { return solution_; }
  Eigen::VectorXd law() const { return design_.base + solution_.beta().head(design_.n_law); }
  /// Of direction' beta; with `more_variance` what is added to the error's square.
  Estimate estimate(double value, const Eigen::VectorXd& direction, double more_variance = 0.0) const {
    const double variance = factor_ * congruence(direction, solution_.covariance())(0, 0) + more_variance;
    const double se = std::sqrt(std::max(0.0, variance));
    const double n_free = errors_.degrees_of_freedom(direction, more_variance > 0.0 ? se : 0.0);
    return student_estimate(value, variance, n_free);
  }
  Eigen::VectorXd direction_of(const Eigen::RowVectorXd& law) const {
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(judged_.data.n_fixed());
    direction.head(design_.n_law) = law.transpose();
    return direction;
  }
  double eps(double v_mps) const {
    return 1.0 + product(design_.law.jacobian(std::span(&v_mps, 1), law()), law())(0, 0);
  }
  Estimate eps_at(double v_mps, double more_variance = 0.0) const {
    return estimate(eps(v_mps), direction_of(design_.law.jacobian(std::span(&v_mps, 1), law()).row(0)), more_variance);
  }
  /// Of a mean of recordings, of which one alone has the standard error `se_of_one`.
  Estimate mean_of_recordings(double value, double variance, double se_of_one) const {
    return student_estimate(value, variance, errors_.degrees_of_freedom_of_a_recording(se_of_one));
  }
  /// Of one more recording as it is measured, on a plate and a day that may be any.
  double variance_of_a_recording() const {
    const Eigen::VectorXd& own = judged_.data.variance;
    double sum = median({own.begin(), own.end()});
    for (const double sd : judged_.deviations) sum += square(sd);
    return sum;
  }
  Eigen::MatrixXd covariance() const { return factor_ * solution_.covariance(); }
  double degrees_of_freedom(const Eigen::VectorXd& direction) const { return errors_.degrees_of_freedom(direction); }

 private:
  const Design& design_;
  const Judged& judged_;
  OffsetSolution solution_;
  ErrorsOfErrors errors_;
  double factor_ = 1.0;
};

void describe_law(BetweenRecordings& result, const Design& design, const Pool& pool) {
  constexpr int kPoints = 60;
  const LawModel& law = design.law;
  const double spread = pool.variance_of_a_recording();
  result.kind = law.kind;
  result.v_mps = design.node_v_mps[design.node_v_mps.size() / 2];
  result.eps = pool.eps_at(result.v_mps);
  result.prediction95 = *pool.eps_at(result.v_mps, spread).ci95;
  for (const double v : design.node_v_mps) result.nodes.push_back({v, pool.eps_at(v)});
  const Eigen::VectorXd q = pool.law().array() + 1.0;
  const Eigen::VectorXd values = law.reported(q);
  const Eigen::MatrixXd rows = law.reported_jacobian(q);
  const std::vector<std::string> names = law.names();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    Estimate a = pool.estimate(values[i], pool.direction_of(rows.row(i)));
    a.identified = 3.0 * *a.se < std::abs(a.value);
    result.parameters.push_back({names[static_cast<std::size_t>(i)], a});
  }
  const Eigen::MatrixXd covariance = pool.covariance().topLeftCorner(design.n_law, design.n_law);
  result.correlation = to_matrix(correlation_of(congruence(rows.transpose(), covariance)));
  for (int k = 0; k < kPoints && !design.v_ends_mps.empty(); ++k) {
    const double v = design.v_ends_mps[0] * pow(design.v_ends_mps[1] / design.v_ends_mps[0], k / (kPoints - 1.0));
    const Estimate e = pool.eps_at(v);
    result.curve.push_back({v, e.value, e.ci95, e.se});
    result.curve_prediction95.push_back(*pool.eps_at(v, spread).ci95);
  }
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

/// Of all recordings used, by one law without drift, groups and tau.
ChiSquareTest heterogeneity_of(const Design& design) {
  OffsetData data = design.data;
  OffsetData::Rows of_law(data.n(), design.n_law + 1);
  of_law << data.h().leftCols(design.n_law), data.m();
  data.h_and_m = of_law;
  data.within = data.within.topLeftCorner(design.n_law, design.n_law).eval();
  data.within_y = data.within_y.head(design.n_law).eval();
  data.n_levels = {0, 0};
  const OffsetSolution solution(data, {0.0, 0.0, 0.0});
  ChiSquareTest test;
  test.chi2 = std::max(0.0, solution.sum_of_squares());
  test.ndf = static_cast<double>(data.n() - design.n_law) + design.within_rank;
  test.p_value = chi2_survival(test.chi2, test.ndf);
  return test;
}

void describe_drift(BetweenRecordings& result, const Design& design, const Pool& pool) {
  if (!design.has_drift) return;
  Drift drift = design.drift;
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(design.data.n_fixed());
  direction[direction.size() - 1] = 1.0 / design.time_unit;
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
    const auto r = static_cast<Eigen::Index>(k);
    const auto row = static_cast<std::size_t>(judged.kept[k]);
    const int day = design.days.of_recording[row], plate = design.plates.of_recording[row];
    if (day < 0) continue;
    double left = judged.data.m()[r] - judged.data.h().row(r).head(design.n_law).dot(beta.head(design.n_law)) -
                  design.plate_constant(beta, plate);
    if (design.plates.effect == GroupEffect::random) left -= pool.solution().effect(design.plate_grouping, plate);
    const auto d = static_cast<std::size_t>(day);
    const double weight = 1.0 / (square(judged.deviations[0]) + judged.data.variance[r]);
    ++rows[d].n;
    rows[d].offset += weight * left;
    weights[d] += weight;
  }
  for (std::size_t d = 0; d < rows.size(); ++d) {
    rows[d].offset /= std::max(weights[d], 1e-300);
    rows[d].se = 1.0 / std::sqrt(weights[d]);
  }
  std::erase_if(rows, [](const GroupRow& row) { return row.n == 0; });
}

/// eps of a plate by the mean of its recordings: the law of all takes it to the reference speed, the drift of all to
/// the middle of the campaign.
void describe_plate(BetweenRecordings& result, const Design& design, const Judged& judged, const Pool& pool,
                    std::size_t plate) {
  const Eigen::Index n_fixed = judged.data.n_fixed(), n_law = design.n_law;
  const Eigen::VectorXd& beta = pool.solution().beta();
  GroupRestitution group{design.plates.names[plate], 0, result.v_mps, {}, {}};
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(n_fixed + 1);  // of the rows, and of their values last
  double weights = 0.0;
  std::map<int, double> of_day;
  for (std::size_t k = 0; k < judged.kept.size(); ++k) {
    const auto row = static_cast<std::size_t>(judged.kept[k]);
    if (design.plates.of_recording[row] != static_cast<int>(plate)) continue;
    const auto r = static_cast<Eigen::Index>(k);
    const double weight = 1.0 / (square(judged.deviations[0]) + judged.data.variance[r]);
    mean += weight * judged.data.h_and_m.row(r);
    weights += weight;
    of_day[design.days.of_recording[row]] += weight;
    ++group.n;
  }
  if (group.n == 0) return;
  mean /= weights;
  const Eigen::RowVectorXd law = design.law.jacobian(std::span(&result.v_mps, 1), pool.law()).row(0);
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(n_fixed);  // from the mean of the recordings to where eps is stated
  direction.head(n_law) = (law - mean.head(n_law)).transpose();
  if (design.has_drift) direction[n_fixed - 1] = -mean[n_fixed - 1];
  double variance = 1.0 / weights + congruence(direction, pool.covariance())(0, 0), of_days = 0.0;
  if (design.days.effect == GroupEffect::random) of_days = square(judged.deviations[design.day_grouping + 1]);
  for (const auto& [day, weight] : of_day) variance += of_days * square(weight / weights);
  const double value = pool.eps(result.v_mps) - law.dot(beta.head(n_law)) + mean[n_fixed] + direction.dot(beta);
  const double of_plates =
      design.plates.effect == GroupEffect::random ? square(judged.deviations[design.plate_grouping + 1]) : 0.0;
  const double se_of_one = std::sqrt(static_cast<double>(group.n) / weights);
  group.eps = pool.mean_of_recordings(value, variance, se_of_one);
  group.prediction95 =
      pool.mean_of_recordings(value, variance + pool.variance_of_a_recording() - of_plates, se_of_one).ci95;
  result.plates.rows.push_back({group.name, group.n, value - result.eps.value, *group.eps.se});
  result.of_plates.push_back(std::move(group));
}

void describe_rows(BetweenRecordings& result, const Design& design, const Judged& judged, const Pool& pool) {
  const Eigen::VectorXd beta = pool.solution().beta().head(design.n_law);
  for (std::size_t k = 0; k < design.of_row.size(); ++k) {
    const auto r = static_cast<Eigen::Index>(k);
    RecordingRow& row = result.rows[design.of_row[k]] = judged.rows[k];
    row.is_used = true;
    row.offset = design.data.m()[r] - design.data.h_and_m.row(r).head(design.n_law).dot(beta);
    row.eps = result.eps.value + row.offset;
    row.se = std::sqrt(design.data.variance[r]);
    result.n_outliers += row.is_outlier;
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
  for (const CampaignRecording& recording : recordings) {
    if (recording.summary.status != FitStatus::ok) continue;
    ++result.n_used;
    result.n_samples += recording.summary.n;
  }
  if (result.n_used < kFewestPooled) {
    result.why = Note{NoteKind::too_few_recordings,
                      {static_cast<double>(result.n_used), static_cast<double>(result.n_recordings),
                       static_cast<double>(kFewestPooled)}};
    return result;
  }
  const Design design = make_design(recordings);
  if (design.data.n() < design.data.n_fixed() + 1) {
    result.why = Note{NoteKind::undetermined_campaign, {static_cast<double>(result.n_used)}};
    return result;
  }
  const Judged judged = judge(design.data);
  const Pool pool(design, judged);
  result.status = FitStatus::ok;
  result.notes = design.notes;
  result.shapes = design.shapes;
  result.heterogeneity = heterogeneity_of(design);
  describe_law(result, design, pool);
  describe_deviations(result, design, judged);
  describe_drift(result, design, pool);
  describe_days(result, design, judged, pool);
  describe_rows(result, design, judged, pool);
  for (std::size_t plate = 0; plate < design.plates.names.size(); ++plate)
    describe_plate(result, design, judged, pool, plate);
  return result;
}

std::vector<GroupRestitution> differing_groups(const BetweenRecordings& between,
                                               const std::optional<GroupDifferences>& differences) {
  const std::vector<GroupRestitution>& plates = between.of_plates;
  bool differ = false;
  if (differences && !differences->rows.empty()) {
    differ = std::any_of(differences->rows.begin(), differences->rows.end(),
                         [](const GroupDifference& row) { return row.p_value.value_or(0.0) < kLevel; });
  } else if (between.plates.deviation) {
    differ = between.plates.deviation->ci95.lo > kLeastDeviation;
  } else if (plates.size() > 1) {
    constexpr double kApart = 3.0;  // standard errors: of six pairs one in 60
    const auto [least, greatest] = std::minmax_element(
        plates.begin(), plates.end(), [](const auto& a, const auto& b) { return a.eps.value < b.eps.value; });
    differ = greatest->eps.value - least->eps.value > kApart * hypot(*greatest->eps.se, *least->eps.se);
  }
  if (!differ) return {};
  return between.plates.effect == GroupEffect::none && differences ? differences->alone : plates;
}

}  // namespace bouncelab::fit
