// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"

// Where NDEBUG is set the library promises the compiler what it asserts, and for wrong TOML, "[.name]", some of that
// does not hold: it is to be checked
#undef NDEBUG
namespace bouncelab::cli {
struct NoToml {};
[[noreturn]] static void refuse_toml() { throw NoToml(); }
}  // namespace bouncelab::cli
#define TOML_ASSERT(holds) ((holds) ? void() : bouncelab::cli::refuse_toml())
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

namespace bouncelab::cli {
namespace {

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// What the command at work does with a section of the file.
struct ConfigSection {
  std::vector<std::string> known;  ///< options of the command that the section is named for
  /// Those that the command at work takes, of itself or of a stage that it runs: it is an error where another is given.
  /// Absent where it does not run that command: keys are checked only.
  std::optional<std::vector<std::string>> taken;
};

/// Names of the options that may stand in a file.
/// @param stage  only those that belong to this stage; empty: all
std::vector<std::string> keys_of(const Command& command, const std::string& stage = "") {
  CommonOptions common;
  std::vector<std::string> keys;
  const std::vector<Section> sections = all_sections(command, common);
  for (const Option& option : options_of(sections)) {
    const std::string name = option_name(*option.member);
    if (!option.member->is_positional && name != "config" && (stage.empty() || holds(option.section->stages, stage)))
      keys.push_back(name);
  }
  return keys;
}

/// Absent where no command is called like the section.
std::optional<ConfigSection> config_section(const Command& command, const std::vector<Command>& all,
                                            const std::string& section) {
  const Command* named = command_named(all, section);
  if (named == nullptr) return std::nullopt;
  const std::vector<std::string> known = keys_of(*named);
  if (section == command.name) return ConfigSection{known, known};
  if (!holds(command.stages, section)) return ConfigSection{known, std::nullopt};
  return ConfigSection{known, keys_of(command, section)};
}

/// A key of the file with its value.
struct Entry {
  std::string section;  ///< empty: at the top level
  std::string key;
  const toml::node* value = nullptr;
};

auto line_of(const toml::node& node) { return node.source().begin.line; }

/// How deep lists go: 0 a single value, 1 a list, 2 a list of lists.
int depth_of(const toml::node& value) {
  const toml::array* list = value.as_array();
  if (list == nullptr) return 0;
  return std::any_of(list->begin(), list->end(), [](const toml::node& element) { return element.is_array(); }) ? 2 : 1;
}

class ConfigReader {
 public:
  ConfigReader(const std::string& file, const Command& command, const std::vector<Command>& all)
      : file_(file), command_(command), all_(all) {}

  std::vector<ConfigOption> options_of(const toml::table& file) {
    rules_[""] = {keys_of(command_), keys_of(command_)};
    for (const auto& [key, value] : file) {
      const std::string name(key.str());
      const toml::table* section = value.as_table();
      if (section == nullptr) {
        entries_.push_back({"", name, &value});
        continue;
      }
      const std::optional<ConfigSection> rules = config_section(command_, all_, name);
      if (!rules) refuse(value, fmt::format("unknown section [{}]; sections are named like commands", printable(name)));
      rules_[name] = *rules;
      for (const auto& [inner, inner_value] : *section)
        entries_.push_back({name, std::string(inner.str()), &inner_value});
    }
    // toml++ keeps keys by alphabet
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return line_of(*a.value) < line_of(*b.value); });
    for (const Entry& entry : entries_) add(entry);
    return options_;
  }

 private:
  using Values = std::vector<std::vector<std::string>>;

  std::string place_of(const toml::node& value) const { return fmt::format("{}: line {}", file_, line_of(value)); }
  [[noreturn]] void refuse(const toml::node& value, const std::string& what) const {
    throw InvalidArgument(place_of(value) + ": " + what);
  }

  void add(const Entry& entry) {
    std::string name = entry.key;
    std::replace(name.begin(), name.end(), '_', '-');
    const std::string key = printable(entry.key), own = command_.name;
    const std::string command = entry.section.empty() ? own : entry.section;
    const ConfigSection& rules = rules_.at(entry.section);
    if (!holds(rules.known, name))
      refuse(*entry.value, fmt::format("unknown key '{}'; bouncelab {} --help lists the options", key, command));
    if (rules.taken && !holds(*rules.taken, name))
      refuse(*entry.value,
             fmt::format("bouncelab {0} does not hand '{1}' on to {2}; options of its own stand at the top "
                         "level or in [{0}]",
                         own, key, command));
    // the top level and all sections that are taken set the same options; others are a world of their own
    const auto [first, is_new] =
        lines_.emplace(std::pair{rules.taken ? "" : entry.section, name}, line_of(*entry.value));
    if (!is_new) refuse(*entry.value, fmt::format("'{}' is given already in line {}", key, first->second));
    const Values values = values_of(entry);
    if (rules.taken) options_.push_back(option_of(entry, name, values));
  }

  /// A scalar as it would be typed.
  std::string typed(const std::string& key, const toml::node& value) const {
    if (const auto* text = value.as_string(); text != nullptr && !text->get().empty()) return text->get();
    if (const auto* flag = value.as_boolean()) return flag->get() ? "true" : "false";
    if (const auto* real = value.as_floating_point()) return fmt::format("{}", real->get());
    if (const auto* integer = value.as_integer()) {
      if (integer->flags() == toml::value_flags::none) return std::to_string(integer->get());
      refuse(value, "key '" + printable(key) + "': integers are decimal here, without prefix");
    }
    refuse(value, "key '" + printable(key) + "' needs a number, a word, true/false, or a list of them");
  }

  /// Of a single value {{value}}, of a list {{a}, {b}}, of a list of lists {{a, b}, {c}}.
  Values values_of(const Entry& entry) const {
    const toml::array* list = entry.value->as_array();
    if (list == nullptr) return {{typed(entry.key, *entry.value)}};
    Values values;
    for (const toml::node& element : *list) {
      std::vector<std::string>& value = values.emplace_back();
      if (const toml::array* inner = element.as_array())
        for (const toml::node& scalar : *inner) value.push_back(typed(entry.key, scalar));
      else
        value.push_back(typed(entry.key, element));
    }
    if (values.empty() || std::any_of(values.begin(), values.end(), [](const auto& value) { return value.empty(); }))
      refuse(*entry.value, "the list of '" + printable(entry.key) + "' is empty");
    return values;
  }

  ConfigOption option_of(const Entry& entry, const std::string& name, const Values& values) const {
    CommonOptions common;
    const Member& member = *option_named(all_sections(command_, common), name)->member;
    const int depth = depth_of(*entry.value);
    const bool repeats = is_repeated(member);  // --channel A --channel B
    const bool joins = member.n_most > 0;      // --height A,B
    ConfigOption result{name, place_of(*entry.value), {}, depth == (repeats || joins ? 2 : 1)};
    if (depth == 2 && !result.is_axis)
      refuse(*entry.value,
             "'" + entry.key + "' takes one value; a list of lists runs through an option that takes several");
    for (const std::vector<std::string>& value : values) {
      if (repeats && value.size() > 1)
        refuse(*entry.value, "'" + entry.key + "' cannot run through lists of several values");
      result.values.push_back(fmt::format("{}", fmt::join(value, ",")));
    }
    if (joins && depth == 1) result.values = {fmt::format("{}", fmt::join(result.values, ","))};
    return result;
  }

  const std::string& file_;
  const Command& command_;
  const std::vector<Command>& all_;
  std::map<std::string, ConfigSection> rules_;  // by section
  std::vector<Entry> entries_;
  std::map<std::pair<std::string, std::string>, toml::source_index> lines_;  // of a section's key
  std::vector<ConfigOption> options_;
};

std::string text_of(const std::string& file) {
  constexpr std::int64_t kMost_bytes = 1'000'000;
  if (!std::filesystem::is_regular_file(file))
    throw FileError(file, "is no regular file; options are read from a TOML file");
  if (const std::int64_t n_bytes = FileBytes(file).size(); n_bytes > kMost_bytes)
    throw FileError(file,
                    fmt::format("{} bytes are no TOML file of options, which has at most {}", n_bytes, kMost_bytes));
  return decoded_text(whole_content(file), file);
}

/// What was typed for an option, the last of several; absent where it was not.
std::optional<std::string> typed_value(const std::vector<std::string>& typed, const std::string& option) {
  std::optional<std::string> value;
  const auto end = std::find(typed.begin(), typed.end(), "--");
  for (auto argument = typed.begin(); argument != end; ++argument) {
    if (*argument == option) value = argument + 1 == end ? "" : argument[1];
    if (argument->starts_with(option + "=")) value = argument->substr(option.size() + 1);
  }
  return value;
}

/// The same TOML in ASCII, its letters beyond that as \UXXXXXXXX; refuses keys of very many parts. toml++ 3.3 takes
/// most of these letters for impossible where it looks for a blank, and runs out of stack for keys of a hundred
/// thousand parts. They may stand between double quotes within a line: so it is known where a string ends.
std::string in_ascii(std::string_view text, const std::string& file) {
  constexpr int kMostDots = 100;  // a section and a key have one
  std::string ascii;
  std::size_t line = 1;
  char quote = '\0';  // or '#', in a comment
  int n_dots = 0;
  for (std::size_t k = 0, n_bytes = 1; k < text.size(); k += n_bytes) {
    const bool is_escape = quote == '"' && text[k] == '\\' && k + 1 < text.size() && text[k + 1] != '\n';
    if (is_escape) ascii += text[k++];
    const char c = text[k];
    if (c == '\n') ++line, quote = '\0', n_dots = 0;
    n_dots += quote == '\0' && c == '.' ? 1 : 0;
    n_bytes = utf8_character(text.substr(k));
    const bool is_letter = n_bytes != 1;  // or no UTF-8
    const bool opens_lines = quote == '\0' && (text.substr(k, 3) == "\"\"\"" || text.substr(k, 3) == "'''");
    if ((is_letter && (n_bytes == 0 || is_escape || (quote != '"' && quote != '#'))) || opens_lines ||
        n_dots > kMostDots)
      throw FileError(
          file,
          fmt::format("line {}: is no TOML; write KEY = VALUE, letters beyond ASCII in double quotes within a line",
                      line));
    ascii += is_letter ? fmt::format("\\U{:08X}", code_point(text.substr(k, n_bytes))) : std::string(1, c);
    if (quote == '\0' && (c == '"' || c == '\'' || c == '#'))
      quote = c;
    else if (c == quote && !is_escape && quote != '#')
      quote = '\0';
  }
  return ascii;
}

}  // namespace

std::vector<ConfigOption> config_options(std::string_view text, const std::string& file, const Command& command,
                                         const std::vector<Command>& all) {
  const std::string ascii = in_ascii(text, file);
  try {
    return ConfigReader(file, command, all).options_of(toml::parse(ascii, std::string_view(file)));
  } catch (const toml::parse_error& error) {
    const auto line = error.source().begin.line;
    throw FileError(file, (line > 0 ? fmt::format("line {}: ", line) : "") + std::string(error.description()));
  } catch (const NoToml&) {
    throw FileError(file, "is no TOML: between [ ] or { } a name is missing");
  }
}

CommandLine line_with_config(const std::vector<std::string>& typed, const Command& command,
                             const std::vector<Command>& all) {
  CommandLine line{typed, {}};
  const std::optional<std::string> path = typed_value(typed, "--config");
  if (!path || typed.back() == "--config") return line;  // of a value that is missing the parser tells
  std::vector<std::string> arguments;
  for (const ConfigOption& option : config_options(text_of(*path), *path, command, all)) {
    if (option.is_axis && !command.runs_through_lists)
      throw InvalidArgument(option.place + ": '" + option.name +
                            "' takes one value; loop and validate run through lists");
    if (typed_value(typed, "--" + option.name)) continue;
    line.from_file.push_back(option);
    if (option.is_axis) continue;
    for (const std::string& value : option.values) arguments.push_back("--" + option.name + "=" + value);
  }
  // before them an option that takes several values would take the input for one; after "--" nothing is an option
  line.arguments.insert(std::find(line.arguments.begin(), line.arguments.end(), "--"), arguments.begin(),
                        arguments.end());
  return line;
}

}  // namespace bouncelab::cli
