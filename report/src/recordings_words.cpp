// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/recordings.hpp"
#include "bouncelab/report/answer.hpp"

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
    what = "the offset from one curve";
  }
  if (values.size() < 2) return {};
  const auto [least, greatest] = std::minmax_element(
      values.begin(), values.end(), [](const ValueOf& a, const ValueOf& b) { return a.value < b.value; });
  return what + formatted(" runs from %.4f (", least->value) + name_of(*least->row) +
         formatted(") to %.4f (", greatest->value) + name_of(*greatest->row) + ")";
}

}  // namespace

std::string in_words(const Recordings& recordings) {
  if (recordings.rows.empty()) return {};
  if (!recordings.test)
    return formatted("the %zu recordings cannot be compared: too few samples of each", recordings.rows.size());
  const RecordingsTest& test = *recordings.test;
  const std::string p = test.p_value < 1e-300 ? "p < 1e-300" : formatted("p = %.2g", test.p_value);
  const std::string by = test.within == WithinUnit::drops ? " by the differences between drops"
                                                          : " if all impacts are independent: too few drops to see";
  const std::string head = formatted("the %zu recordings ", test.n_recordings);
  if (!disagree(recordings)) return head + "agree (" + p + by + ")";
  return head + "do not agree (" + p + by + "): " + extremes(recordings.rows) +
         "; the pooled values are a mean of unlike balls and their errors do not hold: use the row of each recording";
}

}  // namespace bouncelab::report
