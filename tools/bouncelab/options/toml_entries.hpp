// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace bouncelab::cli {

/// A key of a TOML file with its value, as it would be typed on a command line.
struct TomlEntry {
  std::string section;  ///< empty: at the top level
  std::string key;
  std::int64_t line = 0;  ///< from 1

  /// How deep lists go in the value: 0 a single value, 1 a list, 2 a list of lists.
  int depth = 0;
  /// Of a single value: {{value}}. Of a list {{a}, {b}}. Of a list of lists {{a, b}, {c}}. Never empty.
  std::vector<std::vector<std::string>> values;
};

struct TomlSection {
  std::string name;
  std::int64_t line = 0;
};

/// What a TOML file of options says, in its order.
struct TomlEntries {
  std::vector<TomlSection> sections;
  std::vector<TomlEntry> entries;
};

/// Numbers, texts and true/false, lists of them, and lists of such lists, at the top level or in sections. Integers are
/// decimal.
/// @param name  of the file, for messages
/// @throws FileError naming name and line where the text is no TOML, InvalidArgument where a value is none of these
TomlEntries toml_entries(std::string_view text, const std::string& name);

/// The same of a regular file of at most 1 MB: no folder, no device.
/// @throws FileError, InvalidArgument
TomlEntries read_toml_entries(const std::filesystem::path& path);

}  // namespace bouncelab::cli
