// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/toml_entries.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/file_bytes.hpp"
#include "bouncelab/core/text.hpp"
#include "options/tomlplusplus.hpp"

namespace bouncelab::cli {
namespace {

std::int64_t line_of(const toml::node& node) { return static_cast<std::int64_t>(node.source().begin.line); }

[[noreturn]] void refuse_value(const std::string& name, std::int64_t line, const std::string& what) {
  throw InvalidArgument(name + ": line " + std::to_string(line) + ": " + what);
}

/// A scalar as it would be typed.
std::string typed(const toml::node& value, const std::string& name, const std::string& key) {
  if (const auto* text = value.as_string(); text != nullptr && !text->get().empty()) return text->get();
  if (const auto* flag = value.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* real = value.as_floating_point()) return fmt::format("{}", real->get());
  if (const auto* integer = value.as_integer()) {
    if (integer->flags() == toml::value_flags::none) return std::to_string(integer->get());
    refuse_value(name, line_of(value), "key '" + printable(key) + "': integers are decimal here, without prefix");
  }
  refuse_value(name, line_of(value),
               "key '" + printable(key) + "' needs a number, a word, true/false, or a list of them");
}

TomlEntry entry_of(const std::string& section, const std::string& key, const toml::node& value,
                   const std::string& name) {
  TomlEntry entry{section, key, line_of(value), 0, {}};
  const toml::array* list = value.as_array();
  if (list == nullptr) {
    entry.values = {{typed(value, name, key)}};
    return entry;
  }
  entry.depth = 1;
  for (const toml::node& element : *list) {
    entry.values.emplace_back();
    const toml::array* inner = element.as_array();
    if (inner == nullptr) {
      entry.values.back().push_back(typed(element, name, key));
      continue;
    }
    entry.depth = 2;
    for (const toml::node& scalar : *inner) entry.values.back().push_back(typed(scalar, name, key));
  }
  const bool empty = std::any_of(entry.values.begin(), entry.values.end(), [](const auto& v) { return v.empty(); });
  if (entry.values.empty() || empty) refuse_value(name, entry.line, "the list of '" + printable(key) + "' is empty");
  return entry;
}

toml::table parsed(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    const auto line = error.source().begin.line;
    throw FileError(name, (line > 0 ? "line " + std::to_string(line) + ": " : "") + std::string(error.description()));
  }
}

}  // namespace

TomlEntries toml_entries(std::string_view text, const std::string& name) {
  TomlEntries all;
  for (const auto& [key, value] : parsed(text, name)) {
    const std::string key_text(key.str());
    const toml::table* section = value.as_table();
    if (section == nullptr) {
      all.entries.push_back(entry_of("", key_text, value, name));
      continue;
    }
    all.sections.push_back({key_text, line_of(value)});
    for (const auto& [inner_key, inner_value] : *section)
      all.entries.push_back(entry_of(key_text, std::string(inner_key.str()), inner_value, name));
  }
  // toml++ keeps keys by alphabet
  std::stable_sort(all.entries.begin(), all.entries.end(),
                   [](const TomlEntry& a, const TomlEntry& b) { return a.line < b.line; });
  return all;
}

TomlEntries read_toml_entries(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMost_bytes = 1'000'000;
  std::error_code unreadable;
  const auto status = std::filesystem::status(path, unreadable);
  if (!std::filesystem::exists(status)) throw FileError(path.string(), "there is no such file of options");
  if (!std::filesystem::is_regular_file(status))
    throw FileError(path.string(), "not a regular file; options are read from a TOML file");
  const std::uintmax_t n_bytes = std::filesystem::file_size(path, unreadable);
  if (n_bytes > kMost_bytes)
    throw FileError(path.string(),
                    fmt::format("{} bytes are no TOML file of options, which has at most {}", n_bytes, kMost_bytes));
  return toml_entries(whole_content(path), path.string());
}

}  // namespace bouncelab::cli
