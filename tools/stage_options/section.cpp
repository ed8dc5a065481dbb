// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/section.hpp"

namespace bouncelab::options {

std::vector<Option> options_of(const std::vector<Section>& sections) {
  std::vector<Option> options;
  for (const Section& section : sections)
    for (const Member& member : section.description) options.push_back({&member, section.object, &section});
  return options;
}

std::optional<Option> option_named(const std::vector<Section>& sections, const std::string& name) {
  for (const Option& option : options_of(sections))
    if (!option.member->is_positional && option_name(*option.member) == name) return option;
  return std::nullopt;
}

std::string help_of(const Option& option) {
  const std::string_view unnamed = option.section->unnamed;
  return std::string(option.member->text) + (unnamed.empty() ? "" : "; default: " + std::string(unnamed));
}

std::string value_name(const Member& member) {
  using Kind = Member::Kind;
  if (member.kind == Kind::flag) return "";
  if (!member.choices.empty()) return "{" + std::string(member.choices) + "}";
  if (!member.form.empty()) return std::string(member.form);
  if (member.kind == Kind::integer || member.kind == Kind::integers) return "INT";
  if (member.kind == Kind::natural) return "UINT";
  return member.kind == Kind::real || member.kind == Kind::reals ? "FLOAT" : "TEXT";
}

}  // namespace bouncelab::options
