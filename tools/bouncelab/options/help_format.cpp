// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/help_format.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

#include "options/numbers.hpp"

namespace bouncelab::cli {
namespace {

constexpr std::size_t kNames_characters = 30, kLine_characters = 100;

/// Code points of UTF-8.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// The text broken between words, each line but the first behind a column. Breaks of its own stay.
std::string wrapped(const std::string& text, std::size_t column) {
  std::string out;
  std::size_t used = column;
  const std::string indent = "\n" + std::string(column, ' ');
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!out.empty()) {
      const std::size_t own = line.find_first_not_of(' ');
      out += indent + std::string(own == std::string::npos ? 0 : own, ' ');
      used = column + (own == std::string::npos ? 0 : own);
    }
    std::istringstream words(line);
    bool first = true;
    for (std::string word; words >> word; first = false) {
      if (!first && used + 1 + width_of(word) > kLine_characters) {
        out += indent;
        used = column;
        first = true;
      }
      out += (first ? "" : " ") + word;
      used += width_of(word) + (first ? 0 : 1);
    }
  }
  return out;
}

std::string in_capitals(std::string name) {
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

bool takes_several(const CLI::Option& option) { return option.get_items_expected_max() > 1; }

std::string range_of(const CLI::Option& option) {
  const std::string range = type_and_range(option).second;
  return range.empty() || range.front() == '{' ? "" : range;
}

std::string default_of(const CLI::Option& option) {
  std::string text = option.get_default_str();
  if (text.empty() || text == "[]" || text == "inf" || option.get_items_expected_max() == 0) return "";
  if (text.front() == '[') {
    text = text.substr(1, text.size() - 2);
    std::replace(text.begin(), text.end(), ',', ' ');
  }
  return text;
}

std::string description_of(const CLI::Option& option) {
  std::string facts;
  const auto add = [&](const std::string& fact) { facts += (facts.empty() ? "" : "; ") + fact; };
  if (option.get_required() && !option.get_lnames().empty()) add("required");
  if (const std::string range = range_of(option); !range.empty()) add(range);
  if (const std::string value = default_of(option); !value.empty()) add("default " + value);
  return option.get_description() + (facts.empty() ? "" : " (" + facts + ")");
}

std::string in_columns(const std::string& names, const std::string& text) {
  std::string line = "  " + names;
  const std::size_t width = width_of(line);
  line += width + 2 > kNames_characters ? "\n" + std::string(kNames_characters, ' ')
                                        : std::string(kNames_characters - width, ' ');
  return line + wrapped(text, kNames_characters) + "\n";
}

}  // namespace

std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string range = type_and_range(option).second;
  std::vector<std::string> choices;
  if (range.empty() || range.front() != '{') return choices;
  std::istringstream names(range.substr(1, range.size() - 2));
  for (std::string name; std::getline(names, name, ',');) choices.push_back(name);
  return choices;
}

std::string value_name(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  std::string joined;
  for (const std::string& choice : choices_of(option)) joined += (joined.empty() ? "" : "|") + choice;
  if (!joined.empty()) return joined;
  const std::string type = type_and_range(option).first;
  if (type == "INT" || type == "UINT") return "N";
  return type == "FLOAT" ? "X" : type;
}

std::string summary_of(const CLI::App& command) {
  const std::string text = command.get_description();
  return text.substr(0, text.find('\n'));
}

std::string HelpFormat::make_usage(const CLI::App* app, std::string name) const {
  if (!app->get_subcommands({}).empty())
    return "Usage: " + name + " RECORDING...           the answer, and a report beside the recording\n       " + name +
           " COMMAND [OPTIONS] ...  " + name + " COMMAND --help says more\n\n";
  std::string usage = "Usage: " + name + " [OPTIONS]";
  for (const CLI::Option* option : app->get_options()) {
    if (!option->get_positional()) continue;
    usage += " " + in_capitals(option->get_name(true)) + (takes_several(*option) ? "..." : "");
  }
  return usage + "\n\n";
}

std::string HelpFormat::make_description(const CLI::App* app) const {
  return wrapped(app->get_description(), 0) + "\n";
}

// CLI11 puts an empty line between groups of options, but none behind positionals
std::string HelpFormat::make_group(std::string group, bool is_positional,
                                   std::vector<const CLI::Option*> options) const {
  std::string text = group + ":\n";
  for (const CLI::Option* option : options) text += make_option(option, is_positional);
  return text + (is_positional ? "\n" : "");
}

std::string HelpFormat::make_subcommand(const CLI::App* command) const {
  return in_columns(command->get_name(), summary_of(*command));
}

std::string HelpFormat::make_option(const CLI::Option* option, bool is_positional) const {
  std::string names = is_positional ? in_capitals(option->get_name(true)) : option->get_name(false, true);
  std::replace(names.begin(), names.end(), ',', ' ');
  const std::string value = is_positional ? "" : value_name(*option);
  if (!value.empty()) names += " " + value;
  if (takes_several(*option)) names += is_positional ? "..." : " ...";
  return in_columns(names, description_of(*option));
}

}  // namespace bouncelab::cli
