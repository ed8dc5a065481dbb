// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/offset_model.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// A standard deviation from fewer than four differences is known to no better than a factor of three.
constexpr std::size_t kFewestGroups = 5;
constexpr std::ptrdiff_t kFewestRepeats = 5;  // recordings that are not the first of their group

/// A recording's own law as Eigen has it: values less 1.
struct OwnLaw {
  std::vector<double> v_mps;
  Eigen::VectorXd y;
  Cholesky covariance;
};

OwnLaw own_law(const RecordingSummary& summary) {
  const auto n = static_cast<Eigen::Index>(summary.n_nodes);
  return {{summary.v_mps.begin(), summary.v_mps.begin() + n},
          Eigen::Map<const Eigen::Vector3d>(summary.eps.data()).head(n).array() - 1.0,
          cholesky(covariance_of(summary)).value()};  // summarize_recording() has seen to it
}

/// Least eigenvalue of a matrix scaled to a unit diagonal, and how many are not zero.
std::pair<double, double> least_and_rank(const Eigen::MatrixXd& m) {
  const Eigen::VectorXd values = scaled_eigenvalues(m);
  return {values.minCoeff(), static_cast<double>((values.array() > 1e-10).count())};
}

/// Offsets and shapes of all rows by this law. @param base  of the law's coordinates, taken out of the values
OffsetData offsets_of(const std::vector<OwnLaw>& own, const LawModel& law, const Eigen::VectorXd& base) {
  const Eigen::Index n_law = law.n_parameters();
  const auto n = static_cast<Eigen::Index>(own.size());
  OffsetData data;
  data.h_and_m.resize(n, n_law + 1);
  data.variance.resize(n);
  data.within = Eigen::MatrixXd::Zero(n_law, n_law);
  data.within_y = Eigen::VectorXd::Zero(n_law);
  for (Eigen::Index r = 0; r < n; ++r) {
    const OwnLaw& recording = own[static_cast<std::size_t>(r)];
    const Eigen::MatrixXd x = law.jacobian(recording.v_mps, base);  // the law is linear
    const Eigen::MatrixXd weighted_x = recording.covariance.solve(x);
    const Eigen::VectorXd y = recording.y - x * base;
    const Eigen::VectorXd weighted_y = recording.covariance.solve(y);
    const double a = recording.covariance.solve(Eigen::VectorXd::Ones(recording.y.size())).sum();
    const Eigen::VectorXd h = weighted_x.colwise().sum().transpose() / a;
    const double m = weighted_y.sum() / a;
    data.h_and_m.row(r) << h.transpose(), m;
    data.variance[r] = 1.0 / a;
    data.within += transposed_product(x, weighted_x) - a * h * h.transpose();
    data.within_y += transposed_product(x, weighted_y) - a * m * h;
    data.within_yy += y.dot(weighted_y) - a * square(m);
  }
  return data;
}

/// The law with as many constants as the speeds determine.
LawModel law_of(const std::vector<OwnLaw>& own, const std::vector<double>& v_mps, std::vector<Note>& notes) {
  constexpr double kDetermined = 1e-6;
  const std::vector<double> ends = spread_speeds(v_mps, 2);
  if (ends[1] >= kOneSpeed * ends[0])
    for (const std::vector<int>& orders : {std::vector<int>{2, 4, 5}, std::vector<int>{2, 4}}) {
      LawModel law = make_law_model(LawKind::series, orders, v_mps);
      const OffsetData data = offsets_of(own, law, Eigen::VectorXd::Zero(law.n_parameters()));
      const Eigen::MatrixXd information =
          data.within + transposed_product(data.h(), data.variance.cwiseInverse().asDiagonal() * data.h());
      if (!(least_and_rank(information).first > kDetermined)) continue;
      if (orders.size() < 3) notes.push_back({NoteKind::law_of_two_constants});
      return law;
    }
  notes.push_back({NoteKind::one_speed_of_all, {ends[0]}});
  return make_law_model(LawKind::constant, {}, v_mps);
}

/// A law near all recordings: what is left of their values is small, and squares of it are not lost in rounding.
Eigen::VectorXd law_near(const std::vector<OwnLaw>& own, const LawModel& law) {
  const OffsetData data = offsets_of(own, law, Eigen::VectorXd::Zero(law.n_parameters()));
  const Eigen::MatrixXd weighted = data.variance.cwiseInverse().asDiagonal() * data.h();
  return cholesky(data.within + transposed_product(data.h(), weighted))
      .value()
      .solve(data.within_y + transposed_product(weighted, data.m()));
}

GroupLabels labels_of(const std::vector<std::string>& name_of_row) {
  std::set<std::string> names(name_of_row.begin(), name_of_row.end());
  names.erase(std::string());
  GroupLabels labels{{names.begin(), names.end()}, {}};
  for (const std::string& name : name_of_row) {
    const auto found = std::lower_bound(labels.names.begin(), labels.names.end(), name);
    labels.of_recording.push_back(name.empty() ? -1 : static_cast<int>(found - labels.names.begin()));
  }
  return labels;
}

bool is_random(const GroupLabels& labels) {
  const auto n_unknown = std::count(labels.of_recording.begin(), labels.of_recording.end(), -1);
  return labels.names.size() >= kFewestGroups &&
         std::ssize(labels.of_recording) - n_unknown >= std::ssize(labels.names) + kFewestRepeats;
}

bool are_the_same(const GroupLabels& a, const GroupLabels& b) {
  std::set<std::pair<int, int>> pairs;
  for (std::size_t r = 0; r < a.of_recording.size(); ++r) pairs.emplace(a.of_recording[r], b.of_recording[r]);
  return pairs.size() == a.names.size() && pairs.size() == b.names.size();
}

void choose_groups(Design& design) {
  GroupLabels &plates = design.plates, &days = design.days;
  const std::size_t n = design.of_row.size();
  const auto n_law = static_cast<std::size_t>(design.n_law);
  if (is_random(plates))
    plates.effect = GroupEffect::random;
  else if (plates.names.size() > 1 && plates.names.size() < kFewestGroups && n >= n_law + plates.names.size() + 3)
    plates.effect = GroupEffect::fixed;
  else if (plates.names.size() > 1)
    design.notes.push_back(
        {NoteKind::plates_not_in_law, {static_cast<double>(plates.names.size()), static_cast<double>(n)}});
  if (days.names.size() < 2) return;
  if (plates.effect == GroupEffect::random && are_the_same(plates, days))
    design.notes.push_back({NoteKind::plates_are_days});
  else if (is_random(days))
    days.effect = GroupEffect::random;
  else if (days.names.size() < kFewestGroups)
    design.notes.push_back({NoteKind::few_days, {static_cast<double>(days.names.size())}});
}

/// Times of the rows about their mean, in units of the campaign; empty where there is nothing to see a drift by.
Eigen::VectorXd times_of(const std::vector<CampaignRecording>& recordings, Design& design) {
  const auto n = static_cast<Eigen::Index>(design.of_row.size());
  Eigen::VectorXd time(n);
  std::vector<double> known;
  for (const std::size_t k : design.of_row)
    if (recordings[k].origin.date) known.push_back(recordings[k].origin.date->day);
  design.drift.by_date = 2 * known.size() >= design.of_row.size() && !known.empty();
  if (design.drift.by_date) {
    const auto [least, greatest] = std::minmax_element(known.begin(), known.end());
    design.drift.begin = *least;
    design.drift.end = *greatest;
    for (const double day : known) design.drift.middle += day / static_cast<double>(known.size());
    if (known.size() < design.of_row.size())
      design.notes.push_back({NoteKind::dates_missing,
                              {static_cast<double>(design.of_row.size() - known.size()), static_cast<double>(n)}});
  } else {
    design.drift.end = static_cast<double>(n - 1);
    design.drift.middle = 0.5 * design.drift.end;
  }
  design.time_unit = design.drift.end - design.drift.begin;
  design.has_drift = design.time_unit > 0.0;
  if (!design.has_drift) design.notes.push_back({NoteKind::one_date});
  for (Eigen::Index r = 0; r < n; ++r) {
    const auto& date = recordings[design.of_row[static_cast<std::size_t>(r)]].origin.date;
    const double t = design.drift.by_date ? (date ? date->day : design.drift.middle) : static_cast<double>(r);
    time[r] = design.has_drift ? (t - design.drift.middle) / design.time_unit : 0.0;
  }
  return time;
}

/// Law, contrasts of plates, drift.
void add_columns(OffsetData& data, const Design& design, const Eigen::VectorXd& time) {
  const bool has_plates = design.plates.effect == GroupEffect::fixed;
  const auto n_plates = static_cast<Eigen::Index>(design.plates.names.size());
  const Eigen::Index n_law = design.n_law, n_contrasts = has_plates ? n_plates - 1 : 0;
  const Eigen::Index n_columns = n_law + n_contrasts + (design.has_drift ? 1 : 0);
  OffsetData::Rows h = OffsetData::Rows::Zero(data.n(), n_columns + 1);
  h.leftCols(n_law) = data.h();
  h.rightCols(1) = data.m();
  for (Eigen::Index r = 0; has_plates && r < data.n(); ++r) {
    const int plate = design.plates.of_recording[static_cast<std::size_t>(r)];
    if (plate == n_plates - 1)
      h.row(r).segment(n_law, n_contrasts).setConstant(-1.0);
    else if (plate >= 0)
      h(r, n_law + plate) = 1.0;
  }
  if (design.has_drift) h.col(n_columns - 1) = time;
  data.h_and_m = h;
  const auto widened = [&](const Eigen::MatrixXd& m, Eigen::Index columns) {
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(n_columns, columns);
    wide.topLeftCorner(m.rows(), m.cols()) = m;
    return wide;
  };
  data.within = widened(data.within, n_columns);
  data.within_y = widened(data.within_y, 1);
}

void add_groupings(Design& design) {
  OffsetData& data = design.data;
  const bool plates = design.plates.effect == GroupEffect::random, days = design.days.effect == GroupEffect::random;
  // the one with more levels first
  design.plate_grouping = plates && days && design.plates.names.size() < design.days.names.size() ? 1 : 0;
  design.day_grouping = plates ? 1 - design.plate_grouping : 0;
  const auto add = [&](const GroupLabels& labels, std::size_t place) {
    data.level[place] = labels.of_recording;
    data.n_levels[place] = static_cast<int>(labels.names.size());
  };
  if (plates) add(design.plates, design.plate_grouping);
  if (days) add(design.days, design.day_grouping);
}

/// Do the shapes agree? Where not, what they say counts less by Birge's ratio (Phys. Rev. 40, 207 (1932),
/// doi:10.1103/PhysRev.40.207).
void weigh_shapes(Design& design, std::size_t n_values) {
  OffsetData& data = design.data;
  const Eigen::MatrixXd within = data.within.topLeftCorner(design.n_law, design.n_law);
  design.within_rank = within.diagonal().maxCoeff() > 0.0 ? least_and_rank(within).second : 0.0;
  design.shapes.ndf = static_cast<double>(n_values - design.of_row.size()) - design.within_rank;
  if (!(design.shapes.ndf > 0.0)) {
    data.within_yy = 0.0;
    return;
  }
  const Eigen::VectorXd best = least_squares(within, data.within_y.head(design.n_law));
  const double explained = best.dot(data.within_y.head(design.n_law));
  design.shapes.chi2 = std::max(0.0, data.within_yy - explained);
  design.shapes.p_value = chi2_survival(design.shapes.chi2, design.shapes.ndf);
  const double ratio = std::max(1.0, design.shapes.chi2 / design.shapes.ndf);
  data.within /= ratio;
  data.within_y /= ratio;
  data.within_yy = explained / ratio;  // what is left is no part of the offsets' sum of squares
}

}  // namespace

bool is_determined(const OffsetData& data) {
  return least_and_rank(transposed_product(data.h(), data.h()) + data.within * data.variance.mean()).first > 1e-8;
}

double Design::plate_constant(const Eigen::VectorXd& beta, int plate) const {
  if (plates.effect != GroupEffect::fixed || plate < 0) return 0.0;
  const auto n = static_cast<Eigen::Index>(plates.names.size());
  return plate == n - 1 ? -beta.segment(n_law, n - 1).sum() : beta[n_law + plate];
}

Design make_design(const std::vector<CampaignRecording>& recordings) {
  Design design;
  std::vector<OwnLaw> own;
  std::vector<std::string> plates, days;
  std::size_t n_values = 0;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const CampaignRecording& recording = recordings[k];
    if (recording.summary.status != FitStatus::ok) continue;
    design.of_row.push_back(k);
    own.push_back(own_law(recording.summary));
    n_values += recording.summary.n_nodes;
    plates.push_back(recording.origin.plate);
    const auto& date = recording.origin.date;
    days.push_back(date ? day_in_words(date->calendar_day) : std::string());
  }
  std::vector<double> v_mps;
  for (const OwnLaw& recording : own) v_mps.insert(v_mps.end(), recording.v_mps.begin(), recording.v_mps.end());
  design.law = law_of(own, v_mps, design.notes);
  const bool has_speeds = design.law.kind == LawKind::series;
  design.node_v_mps = spread_speeds(v_mps, has_speeds ? 3 : 1);
  design.v_ends_mps = has_speeds ? spread_speeds(v_mps, 2) : std::vector<double>{};
  design.base = law_near(own, design.law);
  design.n_law = design.law.n_parameters();
  design.plates = labels_of(plates);
  design.days = labels_of(days);
  choose_groups(design);
  const Eigen::VectorXd time = times_of(recordings, design);
  const OffsetData offsets = offsets_of(own, design.law, design.base);
  design.data = offsets;
  add_columns(design.data, design, time);
  if (design.plates.effect == GroupEffect::fixed && !is_determined(design.data)) {
    design.plates.effect = GroupEffect::none;
    design.notes.push_back({NoteKind::plates_are_times});
    design.data = offsets;
    add_columns(design.data, design, time);
  }
  add_groupings(design);
  weigh_shapes(design, n_values);
  return design;
}

OffsetData rows_of(const OffsetData& data, const std::vector<Eigen::Index>& rows) {
  OffsetData some = data;
  some.h_and_m = data.h_and_m(rows, Eigen::all);
  some.variance = data.variance(rows);
  for (std::size_t g = 0; g < 2; ++g) {
    some.level[g].clear();
    for (const Eigen::Index r : rows)
      if (data.n_levels[g] > 0) some.level[g].push_back(data.level[g][static_cast<std::size_t>(r)]);
  }
  return some;
}

}  // namespace bouncelab::fit
