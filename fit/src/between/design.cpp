// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/offset_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// A standard deviation from fewer than four differences is known to no better than a factor of three.
constexpr std::size_t kFewestGroups = 5;
constexpr std::ptrdiff_t kFewestRepeats = 5;  // recordings that are not the first of their group
constexpr std::size_t kFewestForDrift = 4;    // recordings more than plates: three degrees of freedom are left

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
  if (is_random(plates))
    plates.effect = GroupEffect::random;
  else if (plates.names.size() > 1 && plates.names.size() < kFewestGroups && n >= plates.names.size() + 2)
    plates.effect = GroupEffect::fixed;
  else if (plates.names.size() > 1)
    design.notes.push_back(
        {NoteKind::plates_not_in_model, {static_cast<double>(plates.names.size()), static_cast<double>(n)}});
  if (days.names.size() < 2) return;
  if (plates.effect == GroupEffect::random && are_the_same(plates, days))
    design.notes.push_back({NoteKind::plates_are_days});
  else if (is_random(days))
    days.effect = GroupEffect::random;
  else if (days.names.size() < kFewestGroups)
    design.notes.push_back({NoteKind::few_days, {static_cast<double>(days.names.size())}});
}

/// Plates that were measured one after the other: two of a few, or all of many, since of many some always are.
void note_plates_apart(Design& design, const std::vector<double>& time) {
  const GroupLabels& plates = design.plates;
  if (plates.effect == GroupEffect::none) return;
  std::vector<Interval> times(plates.names.size(), {HUGE_VAL, -HUGE_VAL});
  for (std::size_t r = 0; r < time.size(); ++r) {
    if (plates.of_recording[r] < 0) continue;
    Interval& of = times[static_cast<std::size_t>(plates.of_recording[r])];
    of = {std::min(of.lo, time[r]), std::max(of.hi, time[r])};
  }
  const auto ends_first = std::min_element(times.begin(), times.end(), [](auto a, auto b) { return a.hi < b.hi; });
  const auto begins_last = std::max_element(times.begin(), times.end(), [](auto a, auto b) { return a.lo < b.lo; });
  if (!(ends_first->hi < begins_last->lo)) return;
  const auto name = [&](auto of) { return printable(plates.names[static_cast<std::size_t>(of - times.begin())]); };
  std::string who = name(ends_first) + " and " + name(begins_last);
  if (plates.effect == GroupEffect::random) {
    std::sort(times.begin(), times.end(), [](auto a, auto b) { return a.lo < b.lo; });
    for (std::size_t k = 1; k < times.size(); ++k)
      if (!(times[k - 1].hi < times[k].lo)) return;
    who = "the plates";
  }
  design.notes.push_back({NoteKind::plates_are_times, {}, who});
}

/// 1, contrasts of plates, drift, and the values.
void set_columns(Design& design, const Eigen::VectorXd& values, const Eigen::VectorXd& time) {
  const Eigen::Index n_columns = design.of_plate(-1).size();
  OffsetData::Rows& h = design.data.h_and_m;
  h = OffsetData::Rows::Zero(values.size(), n_columns + 1);
  for (Eigen::Index r = 0; r < values.size(); ++r)
    h.row(r).head(n_columns) = design.of_plate(design.plates.of_recording[static_cast<std::size_t>(r)]);
  if (design.has_drift) h.col(n_columns - 1) = time;
  h.col(n_columns) = values;
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

}  // namespace

bool is_determined(const OffsetData& data) {
  return scaled_eigenvalues(transposed_product(data.h(), data.h())).minCoeff() > 1e-8;
}

Eigen::VectorXd Design::of_plate(int plate) const {
  const auto n_contrasts = plates.effect == GroupEffect::fixed ? std::ssize(plates.names) - 1 : 0;
  Eigen::VectorXd columns = Eigen::VectorXd::Zero(1 + n_contrasts + (has_drift ? 1 : 0));
  columns[0] = 1.0;
  if (plate == n_contrasts)
    columns.segment(1, n_contrasts).setConstant(-1.0);
  else if (plate >= 0 && n_contrasts > 0)
    columns[1 + plate] = 1.0;
  return columns;
}

const Estimate* eps_at(const RecordingSummary& summary, double v_mps) {
  for (const NodeEstimate& node : summary.nodes)
    if (node.v_mps == v_mps) return &node.eps;
  return nullptr;
}

CampaignTimes times_of(const std::vector<CampaignRecording>& recordings, const std::vector<std::size_t>& used) {
  CampaignTimes times;
  times.of.assign(recordings.size(), 0.0);
  Drift& drift = times.drift;
  std::vector<double> known;
  for (const std::size_t k : used)
    if (recordings[k].origin.date) known.push_back(recordings[k].origin.date->day);
  drift.by_date = 2 * known.size() >= used.size() && !known.empty();
  if (drift.by_date) {
    const auto [least, greatest] = std::minmax_element(known.begin(), known.end());
    drift.begin = *least;
    drift.end = *greatest;
    for (const double day : known) drift.middle += day / static_cast<double>(known.size());
    if (known.size() < used.size())
      times.notes.push_back({NoteKind::dates_missing,
                             {static_cast<double>(used.size() - known.size()), static_cast<double>(used.size())}});
  } else {
    drift.end = static_cast<double>(used.size() - 1);
    drift.middle = 0.5 * drift.end;
  }
  times.has_drift = drift.end > drift.begin;
  if (!times.has_drift) times.notes.push_back({NoteKind::one_date});
  for (std::size_t r = 0; times.has_drift && r < used.size(); ++r) {
    const auto& date = recordings[used[r]].origin.date;
    const double t = drift.by_date ? (date ? date->day : drift.middle) : static_cast<double>(r);
    times.of[used[r]] = (t - drift.middle) / (drift.end - drift.begin);
  }
  return times;
}

Design make_design(const std::vector<CampaignRecording>& recordings, const std::vector<std::size_t>& used,
                   const CampaignTimes& times, double v_mps) {
  Design design;
  design.v_mps = v_mps;
  std::vector<std::string> plates, days;
  std::vector<double> values, variances, time;
  for (const std::size_t k : used) {
    const Estimate* eps = eps_at(recordings[k].summary, v_mps);
    if (!eps) continue;
    design.of_row.push_back(k);
    values.push_back(eps->value);
    variances.push_back(square(*eps->se));
    time.push_back(times.of[k]);
    plates.push_back(recordings[k].origin.plate);
    const auto& date = recordings[k].origin.date;
    days.push_back(date ? day_in_words(date->calendar_day) : std::string());
  }
  const auto column = [](const std::vector<double>& of) {
    return Eigen::Map<const Eigen::VectorXd>(of.data(), std::ssize(of)).eval();
  };
  design.base = column(values).mean();
  const Eigen::VectorXd off = column(values).array() - design.base;
  design.data.variance = column(variances);
  design.plates = labels_of(plates);
  design.days = labels_of(days);
  choose_groups(design);
  note_plates_apart(design, time);
  const std::size_t n_plates = design.plates.effect == GroupEffect::fixed ? design.plates.names.size() : 1;
  design.has_drift = times.has_drift && design.of_row.size() >= n_plates + kFewestForDrift;
  set_columns(design, off, column(time));
  if (design.plates.effect == GroupEffect::fixed && !is_determined(design.data)) {
    design.plates.effect = GroupEffect::none;
    design.plates_are_times = true;
    set_columns(design, off, column(time));
  }
  add_groupings(design);
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
