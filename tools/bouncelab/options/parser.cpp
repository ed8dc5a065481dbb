// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::cli {
namespace {

constexpr std::size_t kNames_characters = 30, kLine_characters = 100;  // of a line of --help
constexpr int kMostValues = 1 << 29;                                   // of an option that is repeated

std::string in_second_column(const std::string& text) { return wrapped(text, kLine_characters - kNames_characters); }

std::string in_whole_width(const std::string& text) { return wrapped(text, kLine_characters); }

/// CLI11's help in columns of our widths.
std::shared_ptr<CLI::Formatter> help_format() {
  auto format = std::make_shared<CLI::Formatter>();
  format->column_width(kNames_characters);
  format->label("SUBCOMMAND", "COMMAND");
  return format;
}

/// What help says of an option: its text, and range and default in brackets.
std::string text_and_facts(const Option& option) {
  const Member& member = *option.member;
  std::string facts = member.is_required && !member.is_positional ? "; required" : "";
  if (const std::string range = range_of(member); !range.empty()) facts += "; " + range;
  const std::string value = default_text(member, option.object);
  if (!value.empty() && value != "inf" && member.kind != Member::Kind::flag) facts += "; default " + value;
  return help_of(option) + (facts.empty() ? "" : " (" + facts.substr(2) + ")");
}

/// A parser of the options of some sections, which sets them.
class Parser {
 public:
  /// @param all  also the options that only --help-all shows
  Parser(const std::vector<Section>& sections, const std::string& summary, const std::string& name, bool all)
      : sections_(sections), app_(in_whole_width(summary), name) {
    app_.formatter(help_format());
    app_.set_help_flag("-h,--help", "This help");
    app_.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    for (const Option& option : options_of(sections_)) add(option, all);
  }
  CLI::App& app() { return app_; }

  Given parse(const std::vector<std::string>& arguments) {
    try {
      app_.parse(std::vector<std::string>{arguments.rbegin(), arguments.rend()});  // CLI11 takes them from the back
      for (const auto& [added, option] : flags_)
        if (added->count() > 0) set_option(option, {added->as<bool>() ? "true" : "false"});
    } catch (const CLI::ParseError& error) {
      const std::string unknown = unknown_option(arguments);
      throw WrongUsage(with_quotations(unknown.empty() ? error.what() : unknown, arguments));
    }
    return given_;
  }

 private:
  void add(const Option& option, bool all) {
    const Member& member = *option.member;
    const Section& section = *option.section;
    if (section.only_in_full_help && !all) return;
    const std::string name = (member.is_positional ? "" : "--") + option_name(member);
    const auto set = [this, option, name](const CLI::results_t& texts) {
      try {
        set_option(option, texts);
      } catch (const InvalidArgument& error) {
        throw CLI::ValidationError(name, error.what());
      }
      return true;
    };
    const std::string text = in_second_column(text_and_facts(option));
    CLI::Option* added = nullptr;
    if (member.kind == Member::Kind::flag) {
      added = app_.add_flag(name, text);
      flags_.emplace_back(added, option);
    } else {
      added = app_.add_option(name, set, text)->option_text(value_name(member) + (is_repeated(member) ? " ..." : ""));
    }
    if (is_repeated(member))
      added->expected(1, kMostValues)->allow_extra_args()->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    added->required(member.is_required);
    if (!section.heading.empty()) added->group(section.heading);
  }

  void set_option(const Option& option, const std::vector<std::string>& texts) {
    const Member& member = *option.member;
    // "$LIST" of a script in which it is not set
    if (std::any_of(texts.begin(), texts.end(), [](const std::string& text) { return text.empty(); }))
      throw InvalidArgument("is empty; give a value, or leave it out");
    const Value value = value_from_texts(member, texts);
    // integers as they are read, 2 for 002
    const bool is_integer = std::holds_alternative<std::int64_t>(value) || std::holds_alternative<std::uint64_t>(value);
    given_[option_name(member)] = is_integer ? std::vector{text_of(value)} : texts;
    member.set(option.object, value);
  }

  /// The first option typed that there is not, and the one that was probably meant; empty where all are known.
  std::string unknown_option(const std::vector<std::string>& typed) const {
    std::vector<std::string> names{"--help"};
    for (const Option& option : options_of(sections_))
      if (!option.member->is_positional) names.push_back("--" + option_name(*option.member));
    for (const std::string& argument : typed) {
      if (argument == "--") break;
      if (argument.rfind("--", 0) != 0) continue;
      const std::string name = argument.substr(0, argument.find('='));
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      for (const auto& [gone, instead] :
           {std::pair{"--bootstrap", "intervals are by drop from 10 drops on"},
            {"--positions", "take distance over the speed of the sound out of the column t_s"},
            {"--robot", "--knocks, --clicks and --speech sound between the drops"},
            {"--shell", "the shell runs all detectors"}})
        if (name == gone) return "'" + name + "' is no option any more; " + instead;
      const std::string nearest = nearest_name(name, names);
      return "unknown option '" + name + "'" + (nearest.empty() ? "" : "; did you mean '" + nearest + "'?");
    }
    return "";
  }

  /// The message in one line, with every long or unprintable word of the command line as quotations show it.
  static std::string with_quotations(std::string message, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
      const std::string value = word.substr(word.find('=') + 1);  // of --option=value, else the word
      const std::string shown = printable(value);
      const auto at = shown == value ? std::string::npos : message.find(value);
      if (at != std::string::npos) message.replace(at, value.size(), shown);
    }
    std::replace(message.begin(), message.end(), '\n', ' ');
    return message;
  }

  std::vector<Section> sections_;
  CLI::App app_;
  std::vector<std::pair<const CLI::Option*, Option>> flags_;  // asked for when all is read
  Given given_;
};

/// A table's columns in the two columns of --help.
std::string columns_in_words(const std::string& heading, Description columns) {
  std::ostringstream out;
  for (const Member& column : columns) {
    std::string text(column.text);
    std::erase(text, '`');
    CLI::detail::format_help(out, std::string(column.name), in_second_column(text), kNames_characters);
  }
  return heading + ":\n" + out.str();
}

}  // namespace

Given set_options(const std::vector<Section>& sections, const std::vector<std::string>& arguments) {
  return Parser(sections, "", "", true).parse(arguments);
}

std::string help_of(const Command& command, bool all) {
  CommonOptions common;
  const std::vector<Section> sections = all_sections(command, common);
  Parser parser(sections, command.summary, "bouncelab " + command.name, all);
  const bool has_more =
      std::any_of(sections.begin(), sections.end(), [](const Section& s) { return s.only_in_full_help; });
  const std::string more = "More options: bouncelab " + command.name + " --help-all";
  std::string footer = has_more && !all ? more + "\n" : "";
  for (const auto& [heading, columns] : command.tables) footer += columns_in_words(heading, columns) + "\n";
  parser.app().footer(footer + command.example);
  return parser.app().help();
}

std::string help_of_all() {
  CLI::App app{
      in_whole_width("bouncelab: the coefficient of restitution of a bouncing ball, simulated and from its sound.\n"
                     "bouncelab RECORDING... gives the answer, and a report beside the recording; bouncelab COMMAND "
                     "--help says more."),
      "bouncelab"};
  app.formatter(help_format());
  app.set_help_flag("-h,--help", "This help");
  app.set_version_flag("--version", "", "Version and commit");
  app.require_subcommand(1);
  for (const Command& command : all_commands())
    app.add_subcommand(command.name, in_second_column(command.summary.substr(0, command.summary.find('\n'))))
        ->group(command.group);
  return app.help();
}

}  // namespace bouncelab::cli
