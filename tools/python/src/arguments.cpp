// SPDX-License-Identifier: GPL-3.0-or-later
#include "arguments.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string_view>
#include <utility>

namespace bouncelab::python {
namespace {

using Json = nlohmann::ordered_json;
using stages::Section;
using Sections = std::vector<Section>;

using stages::sections_of;
/// Those of the scene alone: detectors are functions, and no file is written.
Sections sections_of(stages::Scene& scene) { return stages::scene_sections(scene); }

/// Sets each option to the texts that it was given. @return these
stages::Given set_options(const Sections& sections, const Arguments& arguments) {
  stages::Given given;
  for (const std::string& argument : arguments) {
    const std::string name = argument.substr(2, argument.find('=') - 2);
    const bool has_value = name.size() + 2 < argument.size();
    const std::optional<stages::Option> option = stages::option_named(sections, name);
    if (!option) throw InvalidArgument("--" + name + ": no such option");
    if (has_value == (option->member->kind == Member::Kind::flag))
      throw InvalidArgument("--" + name + (has_value ? ": True or False" : ": needs a value"));
    given[name].push_back(has_value ? argument.substr(name.size() + 3) : "true");
  }
  for (const auto& [name, texts] : given) stages::set_option(sections, name, texts);
  return given;
}

Json json_of(const stages::Option& option) {
  const Member& member = *option.member;
  const bool flag = member.kind == Member::Kind::flag;
  const std::string range = range_of(member);
  return {{"name", option_name(member)},
          {"help", stages::help_of(option)},
          {"type",
           (member.choices.empty() ? "" : "TEXT:") + stages::value_name(member) + (range.empty() ? "" : ":" + range)},
          {"default", default_text(member, option.object)},
          {"flag", flag},
          {"least", flag ? 0 : 1},
          {"most", flag                  ? 0
                   : is_repeated(member) ? 1 << 29
                                         : 1}};
}

template <class Options>
Json options_of() {
  Options options;
  stages::CommonOptions common;
  Sections sections = sections_of(options);
  sections.push_back(stages::common_section(common));
  Json list = Json::array();
  for (const stages::Option& option : stages::options_of(sections)) list.push_back(json_of(option));
  return list;
}

template <class Options>
void add_options(std::map<std::string, Member>& all) {
  Options options;
  stages::CommonOptions common;
  Sections sections = sections_of(options);
  sections.push_back(stages::common_section(common));
  for (const stages::Option& option : stages::options_of(sections))
    all.emplace(option_name(*option.member), *option.member);
}

/// Those of all functions, by name.
const std::map<std::string, Member>& all_options() {
  static const std::map<std::string, Member> all = [] {
    std::map<std::string, Member> made;
    add_options<stages::AnalyzeOptions>(made);
    add_options<stages::CompareOptions>(made);
    add_options<stages::DemOptions>(made);
    add_options<stages::LoopOptions>(made);
    add_options<stages::FitOptions>(made);
    return made;
  }();
  return all;
}

/// The word behind an option, where it is a value of it and not the next of a sentence.
std::string_view value_in(const Member& member, std::string_view behind) {
  if (member.kind == Member::Kind::flag || !behind.starts_with(' ')) return {};
  std::string_view word = behind.substr(1, behind.find(' ', 1) - 1);
  const bool is_named = word.ends_with(':');  // "--unit furlong: heights are in ..."
  while (!word.empty() && std::string_view(";:,.)?").find(word.back()) != std::string_view::npos) word.remove_suffix(1);
  const std::vector<std::string> choices = choices_of(member);
  const bool is_value = is_named || std::find(choices.begin(), choices.end(), word) != choices.end() ||
                        word.find_first_of("0123456789=") != std::string_view::npos;
  return is_value ? word : std::string_view{};
}

}  // namespace

std::string with_keywords(const std::string& text) {
  static const std::regex option("\\B--([a-z][a-z0-9-]*)");  // not within a name
  std::string said;
  std::string_view rest = text;
  for (std::cmatch found; std::regex_search(rest.begin(), rest.end(), found, option);) {
    said += found.prefix().str();
    rest.remove_prefix(static_cast<std::size_t>(found.position(0) + found.length(0)));
    const auto known = all_options().find(found.str(1));
    if (known == all_options().end()) {
      said += found.str(0);
      continue;
    }
    const std::string name = known->first == "as" ? "taken_as" : std::string(known->second.name);
    const std::string_view value = value_in(known->second, rest);
    if (rest.starts_with(':')) {
      said += name;
    } else if (value.empty()) {
      said += name + (known->second.kind == Member::Kind::flag ? "=True" : "=");
    } else {
      said += name + "=" +
              (value.find_first_not_of("0123456789.-") == std::string_view::npos ? std::string(value)
                                                                                 : "'" + std::string(value) + "'");
      rest.remove_prefix(1 + value.size());
      if (rest.starts_with(" --")) said += ",";
    }
  }
  return said + std::string(rest);
}

template <class Options>
using Prepare = std::function<void(Options&, const stages::Given&)>;

template <class Options>
Parsed<Options> parse(const Arguments& arguments, Options files,
                      const std::type_identity_t<Prepare<Options>>& prepare) {
  Parsed<Options> parsed{std::move(files), {}};
  Sections sections = sections_of(parsed.options);
  sections.push_back(stages::common_section(parsed.run.common));
  parsed.run.given = set_options(sections, arguments);
  parsed.run.common.quiet = true;
  parsed.run.command_line = {"bouncelab (Python)"};
  if constexpr (requires { stages::prepare(parsed.options, parsed.run.given); })
    stages::prepare(parsed.options, parsed.run.given);
  if (prepare) prepare(parsed.options, parsed.run.given);
  parsed.run.parameters = stages::parameters_of(sections, parsed.run.given);
  return parsed;
}
template Parsed<stages::AnalyzeOptions> parse(const Arguments&, stages::AnalyzeOptions,
                                              const Prepare<stages::AnalyzeOptions>&);
template Parsed<stages::CompareOptions> parse(const Arguments&, stages::CompareOptions,
                                              const Prepare<stages::CompareOptions>&);
template Parsed<stages::DemOptions> parse(const Arguments&, stages::DemOptions, const Prepare<stages::DemOptions>&);
template Parsed<stages::SimulateOptions> parse(const Arguments&, stages::SimulateOptions,
                                               const Prepare<stages::SimulateOptions>&);
template Parsed<stages::SynthesizeOptions> parse(const Arguments&, stages::SynthesizeOptions,
                                                 const Prepare<stages::SynthesizeOptions>&);
template Parsed<stages::DetectOptions> parse(const Arguments&, stages::DetectOptions,
                                             const Prepare<stages::DetectOptions>&);
template Parsed<stages::RestitutionOptions> parse(const Arguments&, stages::RestitutionOptions,
                                                  const Prepare<stages::RestitutionOptions>&);
template Parsed<stages::FitOptions> parse(const Arguments&, stages::FitOptions, const Prepare<stages::FitOptions>&);
template Parsed<stages::RoughnessOptions> parse(const Arguments&, stages::RoughnessOptions,
                                                const Prepare<stages::RoughnessOptions>&);
template Parsed<stages::LoopOptions> parse(const Arguments&, stages::LoopOptions, const Prepare<stages::LoopOptions>&);

std::string options_json(const std::string& function) {
  static const std::map<std::string, Json (*)()> functions{{"simulate", options_of<stages::SimulateOptions>},
                                                           {"synthesize", options_of<stages::SynthesizeOptions>},
                                                           {"detect", options_of<stages::DetectOptions>},
                                                           {"restitution", options_of<stages::RestitutionOptions>},
                                                           {"fit", options_of<stages::FitOptions>},
                                                           {"roughness", options_of<stages::RoughnessOptions>},
                                                           {"analyze", options_of<stages::AnalyzeOptions>},
                                                           {"compare", options_of<stages::CompareOptions>},
                                                           {"dem", options_of<stages::DemOptions>},
                                                           {"loop", options_of<stages::LoopOptions>},
                                                           {"validate", options_of<stages::Scene>}};
  const auto found = functions.find(function);
  if (found == functions.end()) throw InvalidArgument("no function '" + function + "'");
  return found->second().dump();
}

}  // namespace bouncelab::python
