// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/section.hpp"

#include "bouncelab/core/error.hpp"

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

void set_option(const std::vector<Section>& sections, const std::string& name, const std::vector<std::string>& texts) {
  const std::optional<Option> option = option_named(sections, name);
  if (!option) throw InvalidArgument("--" + name + ": no such option");
  try {
    option->member->set(option->object, value_from_texts(*option->member, texts));
  } catch (const InvalidArgument& error) {
    throw InvalidArgument("--" + name + ": " + error.what());
  }
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
