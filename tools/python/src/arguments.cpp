// SPDX-License-Identifier: GPL-3.0-or-later
#include "arguments.hpp"

#include <map>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "options/commands.hpp"
#include "options/parser.hpp"

namespace bouncelab::python {
namespace {

using Json = nlohmann::ordered_json;
using cli::Section;
using Sections = std::vector<Section>;

Section ball(cli::BallChoice& world, const Description& options) { return {"", &options, &world}; }

Sections sections_of(cli::SimulateOptions& options) {
  static const Description world = cli::ball_options("");
  return {ball(options.world, world), {"", &members_of(&options), &options}, cli::simulation_alone_section(options)};
}
Sections sections_of(cli::SynthesizeOptions& options) {
  static const Description world =
      cli::ball_options("that of the impacts where they were simulated, else steel:6mm on glass");
  return {ball(options.world, world), {"", &members_of(&options), &options}, cli::disturbances_section(options)};
}
Sections sections_of(cli::DetectOptions& options) { return {{"", &members_of(&options.config), &options.config}}; }
Sections sections_of(cli::RestitutionOptions& options) {
  static const Description world = cli::ball_options("not known: drag and contact time stay open");
  return {ball(options.world, world), {"", &members_of(&options), &options}};
}
Sections sections_of(cli::FitOptions& options) {
  static const Description world = cli::ball_options("what the samples say");
  return {ball(options.world, world), {"", &members_of(&options.config), &options.config}};
}
Sections sections_of(cli::RoughnessOptions& options) {
  static const Description world = cli::ball_options("what the samples say, else a solid ball of the paper's radius");
  return {ball(options.world, world), {"", &members_of(&options.config), &options.config}};
}
Sections sections_of(cli::CalibrateOptions& options) { return {{"", &members_of(&options), &options}}; }
Sections sections_of(cli::LoopOptions& options) { return cli::loop_sections(options); }

template <class Options>
Parsed<Options> parse(const Arguments& arguments) {
  Parsed<Options> parsed;
  Sections sections = sections_of(parsed.options);
  sections.push_back(cli::common_section(parsed.run.common));
  try {
    parsed.run.given = cli::set_options(sections, arguments);
  } catch (const cli::WrongUsage& error) {
    throw InvalidArgument(error.what());
  }
  parsed.run.common.quiet = true;
  parsed.run.command_line = {"bouncelab (Python)"};
  parsed.run.arguments = arguments;
  parsed.run.parameters = cli::parameters_of(sections, parsed.run.given);
  return parsed;
}

Json json_of(const cli::Option& option) {
  const Member& member = *option.member;
  const bool flag = member.kind == Member::Kind::flag;
  const std::string range = range_of(member);
  return {
      {"name", option_name(member)},
      {"help", member.text},
      {"type", (member.choices.empty() ? "" : "TEXT:") + cli::value_name(member) + (range.empty() ? "" : ":" + range)},
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
  cli::CommonOptions common;
  Sections sections = sections_of(options);
  sections.push_back(cli::common_section(common));
  Json list = Json::array();
  for (const cli::Option& option : cli::options_of(sections)) list.push_back(json_of(option));
  return list;
}

}  // namespace

Parsed<cli::SimulateOptions> simulate_call(const Arguments& arguments) {
  Parsed<cli::SimulateOptions> parsed = parse<cli::SimulateOptions>(arguments);
  if (parsed.options.preset == "paper") cli::apply_paper_preset(parsed.options, parsed.run);
  return parsed;
}
Parsed<cli::SynthesizeOptions> synthesize_call(const Arguments& arguments) {
  return parse<cli::SynthesizeOptions>(arguments);
}
Parsed<cli::DetectOptions> detect_call(const Arguments& arguments) { return parse<cli::DetectOptions>(arguments); }
Parsed<cli::RestitutionOptions> restitution_call(const Arguments& arguments) {
  return parse<cli::RestitutionOptions>(arguments);
}
Parsed<cli::FitOptions> fit_call(const Arguments& arguments) { return parse<cli::FitOptions>(arguments); }
Parsed<cli::RoughnessOptions> roughness_call(const Arguments& arguments) {
  return parse<cli::RoughnessOptions>(arguments);
}
Parsed<cli::CalibrateOptions> calibrate_call(const Arguments& arguments) {
  Parsed<cli::CalibrateOptions> parsed = parse<cli::CalibrateOptions>(arguments);
  cli::check_calibrate_options(parsed.options, parsed.run.given);
  return parsed;
}
Parsed<cli::LoopOptions> loop_call(const Arguments& arguments) {
  Parsed<cli::LoopOptions> parsed = parse<cli::LoopOptions>(arguments);
  cli::apply_loop_preset(parsed.options, parsed.run);
  return parsed;
}

std::string options_json(const std::string& function) {
  static const std::map<std::string, Json (*)()> functions{{"simulate", options_of<cli::SimulateOptions>},
                                                           {"synthesize", options_of<cli::SynthesizeOptions>},
                                                           {"detect", options_of<cli::DetectOptions>},
                                                           {"restitution", options_of<cli::RestitutionOptions>},
                                                           {"fit", options_of<cli::FitOptions>},
                                                           {"roughness", options_of<cli::RoughnessOptions>},
                                                           {"calibrate", options_of<cli::CalibrateOptions>},
                                                           {"loop", options_of<cli::LoopOptions>}};
  const auto found = functions.find(function);
  if (found == functions.end()) throw InvalidArgument("no function '" + function + "'");
  return found->second().dump();
}

}  // namespace bouncelab::python
