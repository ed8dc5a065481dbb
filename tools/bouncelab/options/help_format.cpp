// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/help_format.hpp"

#include <sstream>

#include "options/numbers.hpp"

namespace bouncelab::cli {
namespace {

constexpr std::size_t kNames_characters = 30, kLine_characters = 100;

/// The text with a line break for a blank where a line would be longer; breaks of its own stay.
std::string wrapped(std::string text, std::size_t width) {
  std::size_t begin = 0, blank = std::string::npos;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] == '\n') {
      begin = k + 1;
      blank = std::string::npos;
    } else if (text[k] == ' ') {
      blank = k;
    }
    if (k - begin < width || blank == std::string::npos) continue;
    text[blank] = '\n';
    begin = blank + 1;
    blank = std::string::npos;
  }
  return text;
}

std::string in_second_column(const std::string& text) { return wrapped(text, kLine_characters - kNames_characters); }

}  // namespace

std::string value_name(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  const auto [type, range] = type_and_range(option);
  return range.starts_with('{') ? range : type;
}

std::string summary_of(const CLI::App& command) {
  const std::string text = command.get_description();
  return text.substr(0, text.find('\n'));
}

HelpFormat::HelpFormat() {
  column_width(kNames_characters);
  label("SUBCOMMAND", "COMMAND");
}

std::string HelpFormat::make_description(const CLI::App* app) const {
  return wrapped(app->get_description(), kLine_characters) + "\n";
}

std::string HelpFormat::make_subcommand(const CLI::App* command) const {
  std::ostringstream out;
  CLI::detail::format_help(out, command->get_name(), in_second_column(summary_of(*command)), kNames_characters);
  return out.str();
}

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  const std::string value = value_name(*option);
  return (value.empty() ? "" : " " + value) + (option->get_items_expected_max() > 1 ? " ..." : "");
}

std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
  std::string facts = option->get_required() && !option->get_positional() ? "; required" : "";
  const std::string range = type_and_range(*option).second, value = option->get_default_str();
  if (!range.empty() && !range.starts_with('{')) facts += "; " + range;
  if (!value.empty() && value != "[]" && value != "inf" && !value_name(*option).empty()) facts += "; default " + value;
  return in_second_column(option->get_description() + (facts.empty() ? "" : " (" + facts.substr(2) + ")"));
}

}  // namespace bouncelab::cli
