// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/nearest_name.hpp"

#include <algorithm>
#include <cstddef>

namespace bouncelab {
namespace {

constexpr std::size_t kLongestName = 64;  // of those that are compared; the work grows with the square

/// Optimal string alignment distance.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearest_name(std::string_view typed, const std::vector<std::string>& names) {
  if (typed.size() > kLongestName) return "";
  std::string best;
  std::size_t least = 0;
  for (const std::string& name : names) {
    const std::size_t d = distance(typed, name);
    if (3 * d > std::max(typed.size(), name.size()) || (!best.empty() && d >= least)) continue;
    best = name;
    least = d;
  }
  return best;
}

}  // namespace bouncelab
