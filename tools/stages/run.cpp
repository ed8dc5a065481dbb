// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/run.hpp"

#include <algorithm>
#include <array>

namespace bouncelab::stages {

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

bool names_outputs(const Parameter& parameter) {
  constexpr std::array kNames{"out", "labels", "truth", "write-surface", "table", "histograms", "figures", "to"};
  return std::find(kNames.begin(), kNames.end(), parameter.name) != kNames.end();
}

void set_parameter(Parameters& parameters, const std::string& name, const std::string& value) {
  for (Parameter& p : parameters)
    if (p.name == name) p.values = {value};
}

}  // namespace bouncelab::stages
