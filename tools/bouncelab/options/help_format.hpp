// SPDX-License-Identifier: GPL-3.0-or-later
/// --help for people: what a value is, its unit, range and default in words, lines of at most 100 characters.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace bouncelab::cli {

/// The names that the option chooses from; empty where it takes any text.
std::vector<std::string> choices_of(const CLI::Option& option);

/// What stands for its value: "X" a real number, "N" an integer, "FILE", "X,Y", "a|b|c"; empty of a flag.
std::string value_name(const CLI::Option& option);

/// First line of what the command says of itself.
std::string summary_of(const CLI::App& command);

/// Options are listed by group; of a command in a list its first line only.
class HelpFormat final : public CLI::Formatter {
 public:
  std::string make_description(const CLI::App* app) const override;
  std::string make_group(std::string group, bool is_positional, std::vector<const CLI::Option*> options) const override;
  std::string make_usage(const CLI::App* app, std::string name) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
};

}  // namespace bouncelab::cli
