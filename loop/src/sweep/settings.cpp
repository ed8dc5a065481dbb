// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/settings.hpp"

#include <algorithm>
#include <sstream>

#include "bouncelab/core/error.hpp"

namespace bouncelab::loop {

std::size_t n_combinations(const std::vector<SweepAxis>& axes) {
  std::size_t n = 1;
  double n_exact = 1.0;  // the product may be beyond all integers
  for (const SweepAxis& axis : axes) {
    n_exact *= static_cast<double>(axis.values.size());
    n = n_exact > static_cast<double>(kMostCombinations) ? n : n * axis.values.size();
  }
  if (n_exact <= static_cast<double>(kMostCombinations)) return n;
  std::ostringstream out;
  out << "the lists have " << n_exact << " combinations; a sweep runs through at most " << kMostCombinations
      << ", each a closed loop of a second or more: shorten the lists, or make several sweeps";
  throw InvalidArgument(out.str());
}

Settings combination(const std::vector<SweepAxis>& axes, std::size_t index) {
  Settings settings;
  for (std::size_t k = axes.size(); k-- > 0;) {
    const SweepAxis& axis = axes[k];
    settings.emplace_back(axis.option, axis.values[index % axis.values.size()]);
    index /= axis.values.size();
  }
  std::reverse(settings.begin(), settings.end());
  return settings;
}

std::string text_of(const Settings& settings) {
  std::string text;
  for (const auto& [option, value] : settings) text += (text.empty() ? "" : ", ") + option + " " + value;
  return text;
}

}  // namespace bouncelab::loop
