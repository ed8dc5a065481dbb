// SPDX-License-Identifier: GPL-3.0-or-later
// Completion of the command line by the shells: their scripts ask the program what may stand at the end of the line.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/help_format.hpp"

namespace bouncelab::cli {
namespace {

// where nothing is offered the shells offer files
constexpr const char* kBash = R"sh(# bash completion of bouncelab
_bouncelab() {
  local IFS=$'\n'
  COMPREPLY=($(compgen -W "$("${COMP_WORDS[0]}" completion words -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null | cut -f1)" \
    -- "${COMP_WORDS[COMP_CWORD]}"))
}
complete -o default -F _bouncelab bouncelab
)sh";

constexpr const char* kZsh = R"sh(#compdef bouncelab
# zsh completion of bouncelab
_bouncelab() {
  local -a offered
  offered=("${(@f)$("$words[1]" completion words -- "${(@)words[2,CURRENT]}" 2>/dev/null | sed 's/:/\\:/g; s/\t/:/')}")
  if [[ -n $offered[1] ]]; then _describe word offered; else _files; fi
}
if [ "$funcstack[1]" = _bouncelab ]; then _bouncelab "$@"; else compdef _bouncelab bouncelab; fi
)sh";

constexpr const char* kFish = R"sh(# fish completion of bouncelab
function __bouncelab_words
  set -l typed (commandline -opc) (commandline -ct)
  bouncelab completion words -- $typed[2..-1] 2>/dev/null
end
complete -c bouncelab -a '(__bouncelab_words)'
)sh";

std::string lines_of(const std::vector<std::string>& words) { return CLI::detail::join(words, "\n"); }

/// What may stand in place of the last word, one a line, with its explanation behind a tab; empty: a file perhaps.
/// @param typed  behind the program's name
std::string offered(const std::vector<std::string>& typed) {
  std::vector<std::string> words;
  for (const CommandName& named : all_commands()) {
    CLI::App app;
    CommonOptions common;
    set_option_defaults(app);
    CLI::App& command = *named.add(app).app;
    if (typed.size() < 2) words.push_back(named.name + "\t" + summary_of(command));
    if (typed.size() < 2 || named.name != typed.front()) continue;
    add_common_options(command, common);
    const std::string& before = typed[typed.size() - 2];
    const CLI::Option* taker = before.starts_with("--") ? command.get_option_no_throw(before) : nullptr;
    if (const std::string value = taker == nullptr ? "" : value_name(*taker); !value.empty())
      return value.starts_with('{') ? lines_of(CLI::detail::split(value.substr(1, value.size() - 2), ',')) : "";
    if (!typed.back().starts_with('-')) return "";
    for (const CLI::Option* option : command.get_options())
      for (const std::string& name : option->get_lnames())
        words.push_back("--" + name + "\t" + CLI::detail::split(option->get_description(), '\n').front());
  }
  return lines_of(words);
}

}  // namespace

Command add_completion_command(CLI::App& app) {
  struct Words {
    std::string shell;
    std::vector<std::string> typed;
  };
  auto words = std::make_shared<Words>();
  CLI::App* command =
      app.add_subcommand("completion", "A script by which bash, zsh or fish complete bouncelab's words");
  command->add_option("shell", words->shell, "bash, zsh or fish; words: what their scripts ask for")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish", "words"}));
  command->add_option("typed", words->typed, "Of `words`: what is typed, the word to complete last");
  command->footer(
      "Examples: bouncelab completion bash > ~/.local/share/bash-completion/completions/bouncelab\n"
      "          bouncelab completion fish > ~/.config/fish/completions/bouncelab.fish\n"
      "          bouncelab completion zsh > DIR/_bouncelab   (DIR in $fpath)");
  return {command, [words](Run&) {
            Outcome outcome;
            outcome.text = words->shell == "bash"   ? kBash
                           : words->shell == "zsh"  ? kZsh
                           : words->shell == "fish" ? kFish
                                                    : offered(words->typed) + "\n";
            return outcome;
          }};
}

}  // namespace bouncelab::cli
