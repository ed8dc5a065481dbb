// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/section.hpp"

namespace bouncelab::options {

std::vector<Option> options_of(const std::vector<Section>& sections) {
  std::vector<Option> options;
  for (const Section& section : sections)
    for (const Member& member : *section.description) options.push_back({&member, section.object, &section});
  return options;
}

std::optional<Option> option_named(const std::vector<Section>& sections, const std::string& name) {
  for (const Option& option : options_of(sections))
    if (!option.member->is_positional && option_name(*option.member) == name) return option;
  return std::nullopt;
}

}  // namespace bouncelab::options
