// SPDX-License-Identifier: GPL-3.0-or-later
#include "marks.hpp"

#include <cmath>

#include "tables.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

/// Do the times increase within a drop? Two marks at one time are for the table's reader to refuse.
bool increase(const Onsets& onsets) {
  for (std::size_t k = 1; k < onsets.size(); ++k)
    if (onsets[k - 1].drop == onsets[k].drop && onsets[k - 1].t_s >= onsets[k].t_s) return false;
  return true;
}

}  // namespace

void check_marks(const audio::Annotations& marks) {
  require(std::isfinite(marks.resolution_s) && marks.resolution_s > 0.0, "the resolution of marks is a positive time");
  for (const audio::Annotation& mark : marks.points) require(std::isfinite(mark.t_s), "times of marks are finite");
}

void check_onsets(const audio::Annotations& marks) {
  for (const bool renumber : {false, true}) {
    Onsets onsets, again;
    if (!accepts([&] { onsets = audio::onsets_of(marks, renumber, "input"); })) continue;
    require(onsets.size() == marks.points.size(), "there is an onset for each mark");
    const Table table = to_table(onsets);
    if (!increase(onsets)) continue;
    must_accept("onsets of marks are a table that can be read", [&] { onsets_from_table(table, "input"); });
    must_accept("onsets of marks can be marks again",
                [&] { again = audio::onsets_of(audio::annotations_of(onsets), false, "input"); });
    require(are_same(table, to_table(again)), "onsets are the same when written as labels and read again");
  }
}

void check_round_trip(const audio::Annotations& marks, double tolerance_s,
                      const std::function<audio::Annotations(const audio::Annotations&)>& write_and_read) {
  if (marks.points.empty()) return;  // no command writes a file without marks, and an empty one is refused
  audio::Annotations again;
  must_accept("marks that were written can be read", [&] { again = write_and_read(marks); });
  require(again.points.size() == marks.points.size(), "as many marks are read as were written");
  for (std::size_t k = 0; k < marks.points.size(); ++k) {
    const audio::Annotation &before = marks.points[k], &after = again.points[k];
    require(before.label == after.label, "labels are the same when written and read again");
    require(std::abs(before.t_s - after.t_s) <= tolerance_s + 1e-14 * std::abs(before.t_s),
            "times are the same when written and read again");
  }
}

}  // namespace bouncelab::fuzz
