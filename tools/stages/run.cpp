// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/run.hpp"

namespace bouncelab::stages {

Description members_of(const CommonOptions*) {
  using O = CommonOptions;
  static constexpr Member options[]{
      member<&O::seed>("seed", "Seed of all random numbers"),
      member<&O::n_threads>("threads", "Threads, 0 = all cores; results do not depend on it").within(0, 1024),
      member<&O::config>("config", "TOML file of options: KEY = VALUE; the command line wins").looks_like("FILE"),
      member<&O::json>("json", "Summary as JSON on standard output"),
      member<&O::quiet>("quiet", "No progress, no summary; errors only"),
      member<&O::force>("force", "Replace outputs that exist")};
  return options;
}

Section common_section(CommonOptions& common) { return section_of(common, "Every command has"); }

Parameters parameters_of(const std::vector<Section>& sections, const Given& given) {
  Parameters parameters;
  for (const Option& option : options_of(sections)) {
    const std::string name = option_name(*option.member);
    const auto typed = given.find(name);
    parameters.push_back(
        {name, typed != given.end() ? typed->second : std::vector{default_text(*option.member, option.object)},
         option.member->is_output});
  }
  return parameters;
}

void set_parameter(Parameters& parameters, const std::string& name, const std::string& value) {
  for (Parameter& p : parameters)
    if (p.name == name) p.values = {value};
}

}  // namespace bouncelab::stages
