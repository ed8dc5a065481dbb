// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "bouncelab/core/error.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {
namespace {

/// Is the option typed on this line?
bool is_typed(const std::vector<std::string>& typed, const std::string& option) {
  return std::any_of(typed.begin(), typed.end(), [&](const std::string& argument) {
    return argument == "--" + option || argument.rfind("--" + option + "=", 0) == 0;
  });
}

std::optional<std::string> config_path(const std::vector<std::string>& typed) {
  std::optional<std::string> path;
  for (std::size_t k = 1; k < typed.size(); ++k) {
    if (typed[k] == "--config" && k + 1 < typed.size()) path = typed[k + 1];
    if (typed[k].rfind("--config=", 0) == 0) path = typed[k].substr(9);
  }
  return path;
}

}  // namespace

CommandLine line_with_config(const std::vector<std::string>& typed, const CLI::App& command) {
  const std::optional<std::string> path = config_path(typed);
  if (!path) return {typed, {}};
  CommandLine line;
  std::vector<std::string> arguments;
  const auto section = [&](const std::string& name) { return config_section(command.get_name(), name); };
  for (const ConfigOption& option : config_options(read_toml_entries(*path), *path, command, section)) {
    if (option.is_axis && command.get_name() != "loop")
      throw InvalidArgument(option.place + ": '" + option.name + "' takes one value; only loop runs through lists");
    if (is_typed(typed, option.name)) continue;
    line.from_file.push_back(option);
    if (option.is_axis) continue;
    for (const std::string& value : option.values) arguments.push_back("--" + option.name + "=" + value);
  }
  // before them an option that takes several values would take the input for one; after "--" nothing is an option
  line.arguments = typed;
  line.arguments.insert(std::find(line.arguments.begin(), line.arguments.end(), "--"), arguments.begin(),
                        arguments.end());
  return line;
}

}  // namespace bouncelab::cli
