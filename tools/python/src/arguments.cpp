// SPDX-License-Identifier: GPL-3.0-or-later
#include "arguments.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"

namespace bouncelab::python {
namespace {

using Json = nlohmann::ordered_json;

void add(CLI::App& app, cli::SimulateOptions& options) { cli::add_simulation_options(app, options); }
void add(CLI::App& app, cli::SynthesizeOptions& options) {
  cli::add_ball_options(app, options.world, "that of the impacts where they were simulated, else steel:6mm on glass");
  cli::add_synthesize_options(app, options);
}
void add(CLI::App& app, cli::DetectOptions& options) { cli::add_detect_options(app, options); }
void add(CLI::App& app, cli::RestitutionOptions& options) {
  cli::add_ball_options(app, options.world, "not known: drag and contact time stay open");
  cli::add_restitution_options(app, options);
}
void add(CLI::App& app, cli::FitOptions& options) {
  cli::add_ball_options(app, options.world, "what the samples say");
  cli::add_fit_options(app, options);
}
void add(CLI::App& app, cli::RoughnessOptions& options) {
  cli::add_ball_options(app, options.world, "what the samples say, else a solid ball of the paper's radius");
  cli::add_roughness_options(app, options);
}
void add(CLI::App& app, cli::CalibrateOptions& options) { cli::add_calibrate_options(app, options); }
void add(CLI::App& app, cli::LoopOptions& options) { cli::add_loop_options(app, options); }

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

template <class Options>
Parsed<Options> parse(const Arguments& arguments, const std::function<void(const CLI::App&, Parsed<Options>&)>& then) {
  Parsed<Options> parsed;
  CLI::App app;
  cli::set_option_defaults(app);
  add(app, parsed.options);
  cli::add_common_options(app, parsed.run.common);
  try {
    app.parse(Arguments(arguments.rbegin(), arguments.rend()));  // CLI11 takes them from the back
  } catch (const CLI::ParseError& error) {
    throw InvalidArgument(in_one_line(error.what()));
  }
  parsed.run.common.quiet = true;
  parsed.run.command_line = {"bouncelab (Python)"};
  parsed.run.arguments = arguments;
  parsed.run.parameters = cli::resolved_parameters(app);
  if (then) then(app, parsed);
  return parsed;
}

Json json_of(const CLI::Option& option) {
  const bool flag = option.get_items_expected_max() == 0;
  return {{"name", option.get_lnames().front()},
          {"help", option.get_description()},
          {"type", option.get_type_name()},
          {"default", flag ? "false" : option.get_default_str()},
          {"flag", flag},
          {"least", option.get_items_expected_min()},
          {"most", option.get_items_expected_max()}};
}

template <class Options>
Json options_of() {
  Options options;
  cli::CommonOptions common;
  CLI::App app;
  cli::set_option_defaults(app);
  add(app, options);
  cli::add_common_options(app, common);
  Json list = Json::array();
  for (const CLI::Option* option : app.get_options())
    if (!option->get_lnames().empty() && option->get_lnames().front() != "help") list.push_back(json_of(*option));
  return list;
}

}  // namespace

Parsed<cli::SimulateOptions> simulate_call(const Arguments& arguments) {
  return parse<cli::SimulateOptions>(arguments, [](const CLI::App& app, Parsed<cli::SimulateOptions>& parsed) {
    if (parsed.options.preset == "paper") cli::apply_paper_preset(app, parsed.options, parsed.run);
  });
}
Parsed<cli::SynthesizeOptions> synthesize_call(const Arguments& arguments) {
  return parse<cli::SynthesizeOptions>(arguments, {});
}
Parsed<cli::DetectOptions> detect_call(const Arguments& arguments) { return parse<cli::DetectOptions>(arguments, {}); }
Parsed<cli::RestitutionOptions> restitution_call(const Arguments& arguments) {
  return parse<cli::RestitutionOptions>(arguments, {});
}
Parsed<cli::FitOptions> fit_call(const Arguments& arguments) { return parse<cli::FitOptions>(arguments, {}); }
Parsed<cli::RoughnessOptions> roughness_call(const Arguments& arguments) {
  return parse<cli::RoughnessOptions>(arguments, {});
}
Parsed<cli::CalibrateOptions> calibrate_call(const Arguments& arguments) {
  return parse<cli::CalibrateOptions>(arguments, {});
}
Parsed<cli::LoopOptions> loop_call(const Arguments& arguments) {
  return parse<cli::LoopOptions>(arguments, [](const CLI::App& app, Parsed<cli::LoopOptions>& parsed) {
    cli::apply_loop_preset(app, parsed.options, parsed.run);
  });
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
