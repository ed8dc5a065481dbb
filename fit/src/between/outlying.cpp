// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/outlying.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "between/design.hpp"
#include "between/variance_components.hpp"
#include "law/distributions.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kLevel = 0.05;

std::array<int, 2> levels_of(const OffsetData& data, Eigen::Index r) {
  std::array<int, 2> level{-1, -1};
  for (std::size_t g = 0; g < 2; ++g)
    if (data.n_levels[g] > 0) level[g] = data.level[g][static_cast<std::size_t>(r)];
  return level;
}

/// Fits the rows that are not out, and judges all.
Judged judged(const OffsetData& data, const std::vector<bool>& out) {
  Judged result;
  for (Eigen::Index r = 0; r < data.n(); ++r)
    if (!out[static_cast<std::size_t>(r)]) result.kept.push_back(r);
  result.data = rows_of(data, result.kept);
  result.deviations = restricted_maximum(result.data);
  const OffsetSolution solution(result.data, result.deviations, true);
  const auto n = static_cast<double>(data.n());
  const ErrorsOfErrors errors(result.data, result.deviations);
  const double near = student_t_quantile(1.0 - 0.5 / n, 1e9);  // of so many rows one is so far off: p = 1
  Eigen::Index k = 0;
  for (Eigen::Index r = 0; r < data.n(); ++r) {
    const bool is_out = out[static_cast<std::size_t>(r)];
    const OffsetSolution::Residual residual =
        is_out ? solution.of_another(data.h.row(r), data.m[r], data.variance[r], levels_of(data, r))
               : solution.without(k++);
    Judged::Row row;
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

}  // namespace

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

}  // namespace bouncelab::fit
