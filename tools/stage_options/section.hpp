// SPDX-License-Identifier: GPL-3.0-or-later
/// Options as data, for whatever lets people set them: command line, Python, page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"

namespace bouncelab::options {

/// The options of one struct, and the object that they set.
struct Section {
  std::string heading;  ///< in --help; empty: the command's own
  Description description;
  void* object = nullptr;
  /// Stages whose options these are: the sections of a configuration file in which they may stand too.
  std::vector<std::string> stages{};
  bool only_in_full_help = false;  ///< shown by --help-all alone
  std::string_view unnamed{};      ///< what is taken where an option is not given, if its default is not the answer
};

/// All options of a struct.
template <class S>
Section section_of(S& object, std::string heading = "", std::vector<std::string> stages = {}) {
  return {std::move(heading), members_of(&object), &object, std::move(stages)};
}

/// An option of a section.
struct Option {
  const Member* member = nullptr;
  void* object = nullptr;
  const Section* section = nullptr;
};
std::vector<Option> options_of(const std::vector<Section>& sections);
/// By the name without dashes in front; absent where there is none, or it is positional.
std::optional<Option> option_named(const std::vector<Section>& sections, const std::string& name);
/// Sets the option of this name. @throws InvalidArgument naming it: there is none, or the texts are no value of it
void set_option(const std::vector<Section>& sections, const std::string& name, const std::vector<std::string>& texts);

/// The text of the member, and what is taken where it is not given.
std::string help_of(const Option& option);
/// What a value looks like, in help and to Python: "FILE", "INT", "X,Y", "{paper,coulomb}"; empty of a flag.
std::string value_name(const Member& member);

}  // namespace bouncelab::options
