// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/config_file.hpp"

#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <sstream>

#include "bouncelab/core/error.hpp"

namespace bouncelab::cli {
namespace {

std::string line_of(const toml::node& node) { return "line " + std::to_string(node.source().begin.line); }

/// A scalar as it would be typed. Empty where the value is of no use on a command line.
std::string typed(const toml::node& value) {
  std::ostringstream out;
  out.precision(17);
  if (const auto* text = value.as_string()) return text->get();
  if (const auto* flag = value.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* whole = value.as_integer()) out << whole->get();
  if (const auto* real = value.as_floating_point()) out << real->get();
  return out.str();
}

class Arguments {
 public:
  Arguments(const std::string& path, const CLI::App& command) : path_(path), command_(command) {}

  void add(std::string key, const toml::node& value) {
    std::replace(key.begin(), key.end(), '_', '-');
    const CLI::Option* option = command_.get_option_no_throw("--" + key);
    if (option == nullptr || key == "config" || key == "help")
      throw InvalidArgument(path_ + ": " + line_of(value) + ": unknown key '" + key + "'; bouncelab " +
                            command_.get_name() + " --help lists the options");
    const auto* array = value.as_array();
    if (array == nullptr || (takes_several(*option) && !holds_lists(*array)))
      result.arguments.push_back("--" + key + "=" + text_of(key, value));
    else
      run_through(key, *array);
  }

  ConfigArguments result;

 private:
  static bool takes_several(const CLI::Option& option) { return option.get_items_expected_max() > 1; }
  static bool holds_lists(const toml::array& array) { return !array.empty() && array.front().is_array(); }

  void run_through(const std::string& key, const toml::array& array) {
    loop::SweepAxis axis{key, {}};
    for (const toml::node& element : array) axis.values.push_back(text_of(key, element));
    if (axis.values.empty())
      throw InvalidArgument(path_ + ": " + line_of(array) + ": the list of '" + key + "' is empty");
    result.lists.push_back(std::move(axis));
  }

  /// A scalar, or scalars joined by commas.
  std::string text_of(const std::string& key, const toml::node& value) const {
    std::string text;
    if (const auto* array = value.as_array()) {
      for (const toml::node& element : *array) text += (text.empty() ? "" : ",") + text_of(key, element);
    } else {
      text = typed(value);
    }
    if (text.empty())
      throw InvalidArgument(path_ + ": " + line_of(value) + ": key '" + key + "' needs a number, a word or true/false");
    return text;
  }

  const std::string& path_;
  const CLI::App& command_;
};

}  // namespace

ConfigArguments config_arguments(const std::string& path, const CLI::App& command,
                                 const std::vector<std::string>& known_sections) {
  toml::table table;
  try {
    table = toml::parse_file(path);
  } catch (const toml::parse_error& error) {
    const auto line = error.source().begin.line;
    throw FileError(path, (line > 0 ? "line " + std::to_string(line) + ": " : "") + std::string(error.description()));
  }
  Arguments arguments(path, command);
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    const auto* section = value.as_table();
    if (section == nullptr) {
      arguments.add(name, value);
      continue;
    }
    if (std::find(known_sections.begin(), known_sections.end(), name) == known_sections.end())
      throw InvalidArgument(path + ": " + line_of(value) + ": unknown section [" + name + "]");
    for (const auto& [inner_key, inner_value] : *section) arguments.add(std::string(inner_key.str()), inner_value);
  }
  return arguments.result;
}

}  // namespace bouncelab::cli
