// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/commands.hpp"

#include <algorithm>

namespace bouncelab::cli {

const Description& members_of(const CommonOptions*) {
  using O = CommonOptions;
  static const Description options{
      member("seed", &O::seed, "Seed of all random numbers"),
      member("threads", &O::n_threads, "Threads, 0 = all cores; results do not depend on it").within(0, 1024),
      member("config", &O::config, "TOML file of options: KEY = VALUE; the command line wins").looks_like("FILE"),
      member("json", &O::json, "Summary as JSON on standard output"),
      member("quiet", &O::quiet, "No progress, no summary; errors only"),
      member("force", &O::force, "Replace outputs that exist")};
  return options;
}

Section common_section(CommonOptions& common) {
  return {"Every command has", &members_of(&common), &common, {}, false};
}

std::vector<Section> all_sections(const Command& command, CommonOptions& common) {
  std::vector<Section> sections = command.sections;
  sections.push_back(common_section(common));
  return sections;
}

const CommandName* command_named(const std::vector<CommandName>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const CommandName& c) { return c.name == name; });
  return found == all.end() ? nullptr : &*found;
}

Parameters parameters_of(const std::vector<Section>& sections, const Given& given) {
  Parameters parameters;
  for (const Option& option : options_of(sections)) {
    const std::string name = option_name(*option.member);
    const auto typed = given.find(name);
    parameters.push_back(
        {name, typed != given.end() ? typed->second : std::vector{default_text(*option.member, option.object)}});
  }
  return parameters;
}

void set_parameter(Parameters& parameters, const std::string& name, const std::string& value) {
  for (Parameter& p : parameters)
    if (p.name == name) p.values = {value};
}

}  // namespace bouncelab::cli
