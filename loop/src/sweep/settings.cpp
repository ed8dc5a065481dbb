// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/settings.hpp"

namespace bouncelab::loop {

std::vector<Settings> combinations(const std::vector<SweepAxis>& axes) {
  std::vector<Settings> all{{}};
  for (const SweepAxis& axis : axes) {
    std::vector<Settings> longer;
    for (const Settings& settings : all)
      for (const std::string& value : axis.values) {
        longer.push_back(settings);
        longer.back().emplace_back(axis.option, value);
      }
    all = std::move(longer);
  }
  return all;
}

std::string text_of(const Settings& settings) {
  std::string text;
  for (const auto& [option, value] : settings) text += (text.empty() ? "" : ", ") + option + " " + value;
  return text;
}

}  // namespace bouncelab::loop
