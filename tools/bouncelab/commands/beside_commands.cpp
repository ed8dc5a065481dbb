// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/report/answer.hpp"
#include "commands/commands.hpp"
#include "options/commands.hpp"
#include "stages/stages.hpp"

namespace bouncelab::cli {
Outcome run_balls() {
  Outcome outcome;
  std::string& text = outcome.text;
  text =
      "--ball: a name; of a material with the diameter, steel:6mm, or the radius, steel:r=3mm. Other numbers follow,\n"
      "steel:6mm,density=7800, or stand alone, radius=20mm,mass=2.7g,inertia=0.65. The density of a hollow ball is\n"
      "its mass over its whole volume. A ball touches the floor as long as Hertz's theory says, where no time stands\n"
      "here; of one's own: table-tennis,contact-time=0.8ms. Words of every day: marble (glass:16mm), marble:25mm,\n"
      "bouncy-ball, ping-pong, soccer, pool. All numbers and their sources: bouncelab balls --json\n\n";
  for (const BallKind& kind : ball_kinds()) {
    text += fmt::format("  {:<17} {}; ", kind.name, kind.what);
    if (kind.diameter_m)
      text += fmt::format("diameter {:.4g} mm, mass {:.4g} g, J = {:.3f} m R^2", 1e3 * *kind.diameter_m,
                          1e3 * mass_kg({0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}}),
                          kind.inertia_factor);
    else
      text += fmt::format("{:.5g} kg/m^3", kind.material.density_kgpm3);
    if (kind.contact) text += fmt::format(", touches the floor for {:.2g} ms at 1 m/s", 1e3 * kind.contact->at_1_mps_s);
    if (const auto& rule = kind.rebound)
      text += fmt::format("; dropped from {:.4g} cm onto {}: {} ({})", 100.0 * rule->height_m, rule->floor,
                          report::asked_rebound(*rule), rule->by);
    text += "\n";
  }
  text += "\n--plate: a name, or E=70GPa,nu=0.22,density=2500\n\n";
  for (const PlateKind& kind : plate_kinds())
    text += fmt::format("  {:<17} {}; {:.4g} kg/m^3, E = {:.4g} GPa, nu = {:.3g}, loss factor {:.2g}\n", kind.name,
                        kind.what, kind.material.density_kgpm3, 1e-9 * kind.material.youngs_modulus_pa,
                        kind.material.poisson_ratio, kind.loss_factor);
  outcome.result = catalogue();
  return outcome;
}

namespace {

// Completion of the command line by the shells: their scripts ask the program what may stand at the end of the line.
// Where they are offered nothing they offer files.
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

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// What can follow the words typed, of which the last is to be completed.
std::string offered(const std::vector<std::string>& typed) {
  std::vector<std::string> words;
  for (const Command& command : all_commands()) {
    if (typed.size() < 2) words.push_back(command.name + "\t" + first_line(command.summary));
    if (typed.size() < 2 || command.name != typed.front()) continue;
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

Outcome run_completion(const CompletionOptions& options, const Run&) {
  Outcome outcome;
  outcome.text = options.shell == "bash"   ? kBash
                 : options.shell == "zsh"  ? kZsh
                 : options.shell == "fish" ? kFish
                                           : offered(options.typed);
  return outcome;
}

}  // namespace bouncelab::cli
