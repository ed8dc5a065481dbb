// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/flags.hpp"

#include <cassert>
#include <utility>

namespace bouncelab {

std::string_view name_of(Flag flag) {
  switch (flag) {
    case Flag::by_hand:
      return "by_hand";
    case Flag::clipped:
      return "clipped";
    case Flag::doubtful:
      return "doubtful";
    case Flag::extra_impact:
      return "extra_impact";
    case Flag::inferred:
      return "inferred";
    case Flag::missing_impact:
      return "missing_impact";
    case Flag::no_position:
      return "no_position";
    case Flag::not_finite:
      return "not_finite";
    case Flag::overlap:
      return "overlap";
  }
  assert(false);
  return {};
}

std::optional<Flag> flag_named(std::string_view word) {
  for (const Flag flag : {Flag::by_hand, Flag::clipped, Flag::doubtful, Flag::extra_impact, Flag::inferred,
                          Flag::missing_impact, Flag::no_position, Flag::not_finite, Flag::overlap})
    if (name_of(flag) == word) return flag;
  return std::nullopt;
}

Flags::Flags(std::initializer_list<Flag> flags) {
  for (const Flag flag : flags) add(flag);
}

Flags Flags::from_text(std::string text) {
  Flags flags;
  flags.text_ = std::move(text);
  return flags;
}

bool Flags::has(Flag flag) const {
  const std::string_view name = name_of(flag);
  std::string_view rest = text_;
  while (!rest.empty()) {
    const auto bar = rest.find('|');
    if (rest.substr(0, bar) == name) return true;
    if (bar == std::string_view::npos) return false;
    rest.remove_prefix(bar + 1);
  }
  return false;
}

std::string_view Flags::first_word() const { return std::string_view(text_).substr(0, text_.find('|')); }

void Flags::add(Flag flag) {
  if (has(flag)) return;
  if (!text_.empty()) text_ += '|';
  text_ += name_of(flag);
}

}  // namespace bouncelab
