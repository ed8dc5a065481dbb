// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/page.hpp"
#include "commands/commands.hpp"
#include "options/commands.hpp"
#include "stages/stages.hpp"

namespace bouncelab::cli {
namespace {

/// "200", or "-" where it is not known.
std::string elastic(const Material& material, double value) {
  return material.youngs_modulus_pa > 0.0 ? fmt::format("{:.4g}", value) : "-";
}

std::string line(const BallKind& kind) {
  std::string diameter = "any", mass = "-";
  if (kind.diameter_m) {
    diameter = fmt::format("{:.4g}", 1e3 * *kind.diameter_m);
    mass = fmt::format("{:.4g}", 1e3 * mass_kg({0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}}));
  }
  const std::string contact = kind.material.hertzian ? "Hertz"
                              : kind.contact         ? fmt::format("{:.2g} ms", 1e3 * kind.contact->at_1_mps_s)
                                                     : "-";
  return fmt::format("{:<17} {:>12} {:>8} {:>16.5g} {:>8} {:>6} {:>10.3f} {:>8}  {}\n", kind.name, diameter, mass,
                     kind.material.density_kgpm3, elastic(kind.material, 1e-9 * kind.material.youngs_modulus_pa),
                     elastic(kind.material, kind.material.poisson_ratio), kind.inertia_factor, contact, kind.what);
}

std::string line(const PlateKind& kind) {
  return fmt::format("{:<17} {:>16.4g} {:>8.4g} {:>6.3g} {:>11.2g} {:>6}  {}\n", kind.name, kind.material.density_kgpm3,
                     1e-9 * kind.material.youngs_modulus_pa, kind.material.poisson_ratio, kind.loss_factor,
                     kind.material.hertzian ? "yes" : "no", kind.what);
}

std::string source_of(const PlateKind& kind) { return kind.source; }
std::string source_of(const BallKind& kind) {
  return kind.source + (kind.contact ? fmt::format("; contact, within {:.0f} %: {}", 100.0 * kind.contact->spread,
                                                   kind.contact_source)
                                     : "");
}
/// What balls of sports have to rebound.
std::string rebound_rules() {
  std::string text;
  for (const BallKind& kind : ball_kinds())
    if (const auto& rule = kind.rebound)
      text += fmt::format("  {:<17} dropped from {:.4g} cm onto {}: {}; {}\n", kind.name, 100.0 * rule->height_m,
                          rule->floor, report::asked_rebound(*rule), rule->source);
  return text;
}

template <class Kind>
std::string sources(const std::vector<Kind>& kinds) {
  std::string text;
  for (const Kind& kind : kinds) text += fmt::format("  {:<17} {}\n", kind.name, source_of(kind));
  return text;
}

/// "marble (glass:16mm)": a word of every day and what it is taken for.
std::string everyday_words() {
  std::string text;
  for (const char* word : {"marble", "bouncy-ball", "ping-pong", "soccer", "pool"})
    text += (text.empty() ? "" : ", ") + std::string(word) + " (" + to_text(ball_from_text(word)) + ")";
  return text;
}

}  // namespace

Outcome run_balls() {
  Outcome outcome;
  outcome.text = fmt::format("{:<17} {:>12} {:>8} {:>16} {:>8} {:>6} {:>10} {:>8}\n", "--ball", "diameter[mm]",
                             "mass[g]", "density[kg/m^3]", "E[GPa]", "nu", "J/(m R^2)", "contact");
  for (const BallKind& kind : ball_kinds()) outcome.text += line(kind);
  outcome.text +=
      "\nAny size: the diameter follows, --ball steel:6mm; a radius is written --ball steel:r=3mm. Other numbers "
      "follow "
      "too:\n--ball steel:6mm,density=7800, or alone: --ball radius=20mm,mass=2.7g,inertia=0.65. The density of a "
      "hollow "
      "ball is its\nmass over its whole volume. Contact: how long it touches the floor at 1 m/s, by Hertz's theory or "
      "as "
      "measured of such\nballs; of one's own: --ball table-tennis,contact-time=0.8ms\nWords of every day are known "
      "too:\n" +
      everyday_words() + ";\na marble of another size: --ball marble:25mm\n\n";
  outcome.text += fmt::format("{:<17} {:>16} {:>8} {:>6} {:>11} {:>6}\n", "--plate", "density[kg/m^3]", "E[GPa]", "nu",
                              "loss factor", "Hertz");
  for (const PlateKind& kind : plate_kinds()) outcome.text += line(kind);
  outcome.text += "\nWhat balls of sports have to rebound\n" + rebound_rules();
  outcome.text +=
      "\nSources of the balls\n" + sources(ball_kinds()) + "Sources of the plates\n" + sources(plate_kinds());
  outcome.result = catalogue();
  return outcome;
}

namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

Outcome run_dem(const DemOptions& options) {
  const std::string content = whole_content(options.fit);
  const auto json = nlohmann::json::parse(content, nullptr, false);
  if (!stages::is_fit(content))
    throw FileError(options.fit, "it is no fit.json of this version; make it anew: bouncelab fit samples.csv");
  if (!json.value("is_one_ball", true))
    throw FileError(
        options.fit,
        "its recordings or drops do not agree, one ε for all would belong to no ball: fit each alone, or all "
        "with --pool");
  std::optional<fit::DemExport> dem;
  try {
    dem = report::dem_of_fit(content);
  } catch (const InvalidArgument& error) {
    throw FileError(options.fit, error.what());
  }
  if (!dem)
    throw FileError(options.fit, "it has nothing for these codes: no law was fitted, or its ε is not between 0 and 1");
  Outcome outcome;
  std::string has;
  for (const fit::Snippet& snippet : dem->snippets) {
    if (lower_case(snippet.program) != options.code) continue;
    has += (has.empty() ? "it has " : ", ") + snippet.model;
    if (!(options.model.empty() || snippet.model == options.model)) continue;
    outcome.text = snippet.text;
    outcome.result = {{"program", snippet.program}, {"model", snippet.model}, {"text", snippet.text}};
    return outcome;
  }
  outcome.error =
      options.fit + ": nothing " + options.model + " for " + options.code + ": " + (has.empty() ? dem->warning : has);
  outcome.exit_code = kNotUsable;
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
                                           : offered(options.typed);
  return outcome;
}

}  // namespace bouncelab::cli
