// SPDX-License-Identifier: GPL-3.0-or-later
// Completion of the command line by the shells, made from the commands' own options.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/help_format.hpp"

namespace bouncelab::cli {
namespace {

struct CompletedOption {
  std::string name;  ///< --out
  std::string help;
  bool takes_value = false;
  std::vector<std::string> choices;  ///< of its value; empty: any, a file perhaps
};

struct CompletedCommand {
  std::string name, help;
  std::vector<CompletedOption> options;
};

std::vector<CompletedCommand> completed_commands() {
  std::vector<CompletedCommand> commands;
  for (const CommandName& named : all_commands()) {
    CLI::App app;
    CommonOptions common;
    set_option_defaults(app);
    const Command command = named.add(app);
    add_common_options(*command.app, common);
    CompletedCommand completed{named.name, summary_of(*command.app), {}};
    for (const CLI::Option* option : command.app->get_options())
      for (const std::string& name : option->get_lnames()) {
        const std::string help = option->get_description();
        completed.options.push_back(
            {"--" + name, help.substr(0, help.find('\n')), !value_name(*option).empty(), choices_of(*option)});
      }
    commands.push_back(completed);
  }
  return commands;
}

std::string without(std::string text, const std::string& characters) {
  std::erase_if(text, [&](char c) { return characters.find(c) != std::string::npos; });
  return text;
}

std::string joined_names(const CompletedCommand& command) {
  std::string names;
  for (const CompletedOption& option : command.options) names += (names.empty() ? "" : " ") + option.name;
  return names;
}

// where it offers nothing the shell offers files
std::string bash_completion(const std::vector<CompletedCommand>& commands) {
  std::string names, values, options;
  for (const CompletedCommand& command : commands) {
    names += (names.empty() ? "" : " ") + command.name;
    options += fmt::format("    {}) words='{}' ;;\n", command.name, joined_names(command));
    std::string files;
    for (const CompletedOption& option : command.options) {
      if (!option.choices.empty())
        values +=
            fmt::format("    '{} {}') words='{}' ;;\n", command.name, option.name, fmt::join(option.choices, " "));
      else if (option.takes_value)
        files += fmt::format("{}'{} {}'", files.empty() ? "" : "|", command.name, option.name);
    }
    values += fmt::format("    {}) return ;;\n", files);
  }
  return fmt::format(R"(# bash completion of bouncelab
_bouncelab() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}} words=
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{}' -- "$cur"))
    return
  fi
  case "$command $prev" in
{}  esac
  [ -n "$words" ] || [ "${{cur#-}}" = "$cur" ] || case "$command" in
{}  esac
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
}}
complete -o default -F _bouncelab bouncelab
)",
                     names, values, options);
}

std::string zsh_completion(const std::vector<CompletedCommand>& commands) {
  const std::string special = "'[]:\\`$";
  std::string names, cases;
  for (const CompletedCommand& command : commands) {
    names += fmt::format("    '{}:{}'\n", command.name, without(command.help, special));
    cases += fmt::format("    {})\n      _arguments \\\n", command.name);
    for (const CompletedOption& option : command.options) {
      std::string value;
      if (!option.choices.empty())
        value = fmt::format(":value:({})", fmt::join(option.choices, " "));
      else if (option.takes_value)
        value = ":value:_files";
      cases += fmt::format("        '{}[{}]{}' \\\n", option.name, without(option.help, special), value);
    }
    cases += "        '*:file:_files'\n      ;;\n";
  }
  return fmt::format(R"(#compdef bouncelab
# zsh completion of bouncelab
_bouncelab() {{
  local -a commands
  commands=(
{}  )
  if (( CURRENT == 2 )); then
    _describe command commands
    _files
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT-- ))
  case $command in
{}  esac
}}
if [ "$funcstack[1]" = _bouncelab ]; then _bouncelab "$@"; else compdef _bouncelab bouncelab; fi
)",
                     names, cases);
}

std::string fish_completion(const std::vector<CompletedCommand>& commands) {
  std::string text = "# fish completion of bouncelab\n";
  for (const CompletedCommand& command : commands) {
    text += fmt::format("complete -c bouncelab -n __fish_use_subcommand -a {} -d '{}'\n", command.name,
                        without(command.help, "'\\"));
    for (const CompletedOption& option : command.options) {
      std::string value;
      if (!option.choices.empty())
        value = fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
      else if (option.takes_value)
        value = " -r";
      text += fmt::format("complete -c bouncelab -n '__fish_seen_subcommand_from {}' -l {}{} -d '{}'\n", command.name,
                          option.name.substr(2), value, without(option.help, "'\\"));
    }
  }
  return text;
}

}  // namespace

Command add_completion_command(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("completion", "A script by which bash, zsh or fish complete bouncelab's words");
  command->add_option("shell", *shell, "bash, zsh or fish")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->footer(
      "Examples: bouncelab completion bash > ~/.local/share/bash-completion/completions/bouncelab\n"
      "          bouncelab completion fish > ~/.config/fish/completions/bouncelab.fish\n"
      "          bouncelab completion zsh > DIR/_bouncelab   (DIR in $fpath)");
  return {command, [shell](Run&) {
            const std::vector<CompletedCommand> commands = completed_commands();
            Outcome outcome;
            outcome.text = *shell == "bash"  ? bash_completion(commands)
                           : *shell == "zsh" ? zsh_completion(commands)
                                             : fish_completion(commands);
            return outcome;
          }};
}

}  // namespace bouncelab::cli
