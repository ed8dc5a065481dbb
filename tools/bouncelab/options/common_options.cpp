// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/common_options.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <system_error>

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

namespace {

/// @throws CLI::ValidationError
Shard shard_from(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, shard.index);
  const bool has_slash = first == std::errc() && slash != end && *slash == '/';
  const auto [last, second] = has_slash ? std::from_chars(slash + 1, end, shard.n) : std::from_chars(end, end, shard.n);
  if (second != std::errc() || last != end || shard.n < 1 || shard.index < 1 || shard.index > shard.n)
    throw CLI::ValidationError("'" + text + "' is not I/N with I from 1 to N, 3/8 for instance");
  return shard;
}

}  // namespace

void add_shard_option(CLI::App& app) {
  const auto check = [](const std::string& text) {
    try {
      shard_from(text);
      return std::string();
    } catch (const CLI::ValidationError& error) {
      return std::string(error.what());
    }
  };
  app.add_option_function<std::string>(
         "--shard", [](const std::string&) {},
         "Part I of N alone, kept in OUT.parts; bouncelab merge puts the parts together")
      ->type_name("I/N")
      ->check(CLI::Validator(check, ""));
}

std::optional<Shard> shard_of(const CLI::App& app) {
  const CLI::Option* option = app.get_option_no_throw("--shard");
  if (option == nullptr || option->count() == 0) return std::nullopt;
  return shard_from(option->reduced_results().back());
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
