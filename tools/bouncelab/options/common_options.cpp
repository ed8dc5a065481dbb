// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/common_options.hpp"

#include <CLI/CLI.hpp>

#include "options/numbers.hpp"

namespace bouncelab::cli {

void set_option_defaults(CLI::App& app) {
  app.option_defaults()->always_capture_default()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

void add_common_options(CLI::App& app, CommonOptions& common) {
  const char* group = "Every command has";
  app.add_option("--seed", common.seed, "Seed of all random numbers")->group(group);
  app.add_option("--threads", common.n_threads, "Threads, 0 = all cores; results do not depend on it")
      ->check(within(0, 1024))
      ->group(group);
  app.add_option("--config", common.config, "TOML file of options: KEY = VALUE; the command line wins")
      ->type_name("FILE")
      ->group(group);
  app.add_flag("--json", common.json, "Summary as JSON on standard output")->group(group);
  app.add_flag("--quiet", common.quiet, "No progress, no summary; errors only")->group(group);
  app.add_flag("--force", common.force, "Replace outputs that exist")->group(group);
  read_numbers_in_decimal(app);
}

std::vector<std::string> config_keys(const CLI::App& app) {
  std::vector<std::string> keys;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames())
      if (name != "help" && name != "config") keys.push_back(name);
  return keys;
}

Parameters resolved_parameters(const CLI::App& app) {
  Parameters parameters;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_lnames().empty() ? option->get_name() : option->get_lnames().front();
    if (name == "help") continue;
    if (option->count() > 0)
      parameters.push_back({name, option->reduced_results()});
    else
      parameters.push_back({name, {option->get_items_expected_max() == 0 ? "false" : option->get_default_str()}});
  }
  return parameters;
}

void set_parameter(Parameters& parameters, const std::string& name, const std::string& value) {
  for (Parameter& p : parameters)
    if (p.name == name) p.values = {value};
}

}  // namespace bouncelab::cli
