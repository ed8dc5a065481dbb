// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/recordings.hpp"
#include "words.hpp"

#include <algorithm>
#include <map>

#include "bouncelab/core/text.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

/// What one recording has at a speed or, where no two have been there, its offset.
struct ValueOf {
  double value;
  const RecordingFit* row;
};

/// The node that the most recordings reach; the middle one of equals.
std::vector<ValueOf> at_common_node(const std::vector<RecordingFit>& rows, double& v_mps) {
  std::map<double, std::vector<ValueOf>> nodes;
  for (const RecordingFit& row : rows)
    for (const NodeEstimate& node : row.nodes) nodes[node.v_mps].push_back({node.eps.value, &row});
  std::vector<std::pair<double, std::vector<ValueOf>>> best;
  for (auto& node : nodes) {
    if (!best.empty() && node.second.size() < best.front().second.size()) continue;
    if (!best.empty() && node.second.size() > best.front().second.size()) best.clear();
    best.emplace_back(std::move(node));
  }
  if (best.empty()) return {};
  v_mps = best[best.size() / 2].first;
  return best[best.size() / 2].second;
}

std::string name_of(const RecordingFit& row) {
  return row.recording.empty() ? "without name" : printable(row.recording);
}

std::string extremes(const std::vector<RecordingFit>& rows) {
  double v_mps = 0.0;
  std::vector<ValueOf> values = at_common_node(rows, v_mps);
  std::string what = formatted("ε at %.3g m/s", v_mps);
  if (values.size() < 2) {
    values.clear();
    for (const RecordingFit& row : rows)
      if (row.offset) values.push_back({row.offset->value, &row});
    what = "the difference from the common curve";
  }
  if (values.size() < 2) return {};
  const auto [least, greatest] = std::minmax_element(
      values.begin(), values.end(), [](const ValueOf& a, const ValueOf& b) { return a.value < b.value; });
  return what + formatted(" runs from %.4f (", least->value) + name_of(*least->row) +
         formatted(") to %.4f (", greatest->value) + name_of(*greatest->row) + ")";
}

}  // namespace

std::optional<Note> note_of_difference(const Recordings& recordings) {
  if (!disagree(recordings)) return std::nullopt;
  const RecordingsTest& test = *recordings.test;
  return Note{
      NoteKind::recordings_differ, {static_cast<double>(test.n_recordings), test.p_value}, extremes(recordings.rows)};
}

std::string in_words(const Recordings& recordings) {
  if (recordings.rows.empty()) return {};
  if (const auto differ = note_of_difference(recordings)) return in_words(*differ);
  if (!recordings.test)
    return formatted("the %zu recordings cannot be compared: each has too few samples", recordings.rows.size());
  const RecordingsTest& test = *recordings.test;
  return formatted("the %zu recordings agree (p = %.2g", test.n_recordings, test.p_value) +
         (test.within == WithinUnit::drops
              ? " by the differences between drops)"
              : " if all impacts are independent; too few drops to know whether they are)");
}

}  // namespace bouncelab::report
