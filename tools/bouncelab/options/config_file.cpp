// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/config_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <map>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"

namespace bouncelab::cli {
namespace {

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

class ConfigReader {
 public:
  ConfigReader(const std::string& file, const CLI::App& command) : file_(file), command_(command) {
    own_.use = ConfigSection::Use::own;
    own_.known = config_keys(command);
  }

  void add(const TomlEntry& entry, const std::optional<ConfigSection>& section) {
    std::string name = entry.key;
    std::replace(name.begin(), name.end(), '_', '-');
    const ConfigSection& rules = section ? *section : own_;
    const std::string command = section ? entry.section : command_.get_name();
    if (!holds(rules.known, name))
      refuse(entry, "unknown key '" + printable(entry.key) + "'; bouncelab " + command + " --help lists the options");
    if (rules.use == ConfigSection::Use::stage && !holds(rules.taken, name))
      refuse(entry,
             fmt::format("bouncelab {0} does not hand '{1}' on to {2}; options of its own stand at the top level "
                         "or in [{0}]",
                         command_.get_name(), printable(entry.key), command));
    const bool is_taken = rules.use != ConfigSection::Use::other;
    // the top level and all sections that are taken set the same options; others are a world of their own
    const auto [first, is_new] = lines_.emplace(std::pair{is_taken ? "" : entry.section, name}, entry.line);
    if (!is_new) refuse(entry, fmt::format("'{}' is given already in line {}", entry.key, first->second));
    if (is_taken) options.push_back(option_of(entry, name));
  }

  std::vector<ConfigOption> options;

 private:
  [[noreturn]] void refuse(const TomlEntry& entry, const std::string& what) const {
    throw InvalidArgument(place_of(entry) + ": " + what);
  }

  std::string place_of(const TomlEntry& entry) const { return file_ + ": line " + std::to_string(entry.line); }

  ConfigOption option_of(const TomlEntry& entry, const std::string& name) const {
    const CLI::Option& option = *command_.get_option("--" + name);
    ConfigOption result{name, place_of(entry), {}, false};
    const bool repeats = option.get_items_expected_max() > 1;  // --channel A --channel B
    const bool joins = takes_list(option);                     // --height A,B
    result.is_axis = entry.depth == (repeats || joins ? 2 : 1);
    if (entry.depth == 2 && !result.is_axis)
      refuse(entry, "'" + entry.key + "' takes one value; a list of lists runs through an option that takes several");
    for (const std::vector<std::string>& value : entry.values) {
      if (repeats && value.size() > 1) refuse(entry, "'" + entry.key + "' cannot run through lists of several values");
      result.values.push_back(fmt::format("{}", fmt::join(value, ",")));
    }
    if (joins && entry.depth == 1) result.values = {fmt::format("{}", fmt::join(result.values, ","))};
    return result;
  }

  const std::string& file_;
  const CLI::App& command_;
  ConfigSection own_;
  std::map<std::pair<std::string, std::string>, std::int64_t> lines_;  // of the section's key
};

}  // namespace

std::vector<ConfigOption> config_options(const TomlEntries& toml, const std::string& file, const CLI::App& command,
                                         const ConfigSections& sections) {
  std::map<std::string, std::optional<ConfigSection>> rules{{"", std::nullopt}};
  for (const TomlSection& section : toml.sections) {
    rules[section.name] = sections(section.name);
    if (!rules[section.name])
      throw InvalidArgument(fmt::format("{}: line {}: unknown section [{}]; sections are named like commands", file,
                                        section.line, printable(section.name)));
  }
  ConfigReader reader(file, command);
  for (const TomlEntry& entry : toml.entries) reader.add(entry, rules.at(entry.section));
  return reader.options;
}

}  // namespace bouncelab::cli
