// SPDX-License-Identifier: GPL-3.0-or-later
/// --help for people: units, range and default of an option in its description, lines of at most 100 characters.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace bouncelab::cli {

/// What stands for its value: "FLOAT", "FILE", "X,Y", "{a,b,c}"; empty of a flag.
std::string value_name(const CLI::Option& option);

/// First line of what the command says of itself.
std::string summary_of(const CLI::App& command);

class HelpFormat final : public CLI::Formatter {
 public:
  HelpFormat();
  std::string make_description(const CLI::App* app) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace bouncelab::cli
