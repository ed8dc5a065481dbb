// SPDX-License-Identifier: GPL-3.0-or-later
// Completion of the command line by the shells: their scripts ask the program what may stand at the end of the line.
#include <memory>
#include <string>
#include <vector>

#include "commands/beside_commands.hpp"
#include "options/commands.hpp"

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

std::string lines_of(const std::vector<std::string>& words) {
  std::string lines;
  for (const std::string& word : words) lines += (lines.empty() ? "" : "\n") + word;
  return lines;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// What can follow the words typed, of which the last is to be completed.
std::string offered(const std::vector<std::string>& typed) {
  std::vector<std::string> words;
  for (const CommandName& named : all_commands()) {
    const Command command = named.make();
    if (typed.size() < 2) words.push_back(named.name + "\t" + first_line(command.summary));
    if (typed.size() < 2 || named.name != typed.front()) continue;
    CommonOptions common;
    const std::vector<Section> sections = all_sections(command, common);
    const std::string& before = typed[typed.size() - 2];
    const std::optional<Option> taker =
        before.starts_with("--") ? option_named(sections, before.substr(2)) : std::nullopt;
    if (taker && taker->member->kind != Member::Kind::flag) return lines_of(choices_of(*taker->member));
    if (!typed.back().starts_with('-')) return "";
    for (const Option& option : options_of(sections))
      if (!option.member->is_positional)
        words.push_back("--" + option_name(*option.member) + "\t" + first_line(help_of(option)));
    words.emplace_back("--help\tThis help");
  }
  return lines_of(words);
}

}  // namespace

Outcome run_completion(const CompletionOptions& options) {
  Outcome outcome;
  outcome.text = options.shell == "bash"   ? kBash
                 : options.shell == "zsh"  ? kZsh
                 : options.shell == "fish" ? kFish
                                           : offered(options.typed) + "\n";
  return outcome;
}

}  // namespace bouncelab::cli
