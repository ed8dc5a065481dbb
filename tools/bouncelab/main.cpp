// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "analyze_command.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/version.hpp"
#include "calibrate_command.hpp"
#include "command.hpp"
#include "config_file.hpp"
#include "detect_command.hpp"
#include "fit_command.hpp"
#include "loop_command.hpp"
#include "progress_line.hpp"
#include "report_command.hpp"
#include "restitution_command.hpp"
#include "simulate_command.hpp"
#include "synthesize_command.hpp"

namespace bouncelab::cli {
namespace {

const std::vector<std::string> kConfigSections{"simulate", "synthesize", "detect", "restitution", "fit"};

void add_common_options(CLI::App& app, CommonOptions& common) {
  const char* group = "Every command has";
  app.add_option("--seed", common.seed, "Seed of all random numbers")->group(group);
  app.add_option("--threads", common.n_threads, "Threads, 0 = all cores; results do not depend on it")
      ->check(CLI::Range(0, 1024))
      ->group(group);
  app.add_option("--config", common.config, "TOML file of options: KEY = VALUE; the command line wins")->group(group);
  app.add_flag("--json", common.json, "Summary as JSON on standard output")->group(group);
  app.add_flag("--quiet", common.quiet, "No progress, no summary; errors only")->group(group);
  app.add_flag("--force", common.force, "Replace outputs that exist")->group(group);
}

/// Every option with the value in force, as given or by default.
Json resolved_parameters(const CLI::App& app) {
  Json parameters = Json::object();
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_lnames().empty() ? option->get_name() : option->get_lnames().front();
    if (name == "help") continue;
    if (option->count() == 0)
      parameters[name] = option->get_items_expected_max() == 0 ? "false" : option->get_default_str();
    else if (option->results().size() == 1)
      parameters[name] = option->results().front();
    else
      parameters[name] = option->results();
  }
  return parameters;
}

/// Puts the configuration file's keys between the command's name and the rest of the line, so that the line wins.
std::vector<std::string> with_config(const std::vector<std::string>& arguments, const CLI::App& app) {
  if (arguments.empty()) return arguments;
  const auto named = app.get_subcommands([&](const CLI::App* c) { return c->check_name(arguments.front()); });
  if (named.empty()) return arguments;
  const CLI::App* command = named.front();
  std::string path;
  for (std::size_t k = 1; k < arguments.size(); ++k) {
    if (arguments[k] == "--config" && k + 1 < arguments.size()) path = arguments[k + 1];
    if (arguments[k].rfind("--config=", 0) == 0) path = arguments[k].substr(9);
  }
  if (path.empty()) return arguments;
  std::vector<std::string> all{arguments.front()};
  const auto from_file = config_arguments(path, *command, kConfigSections);
  all.insert(all.end(), from_file.begin(), from_file.end());
  all.insert(all.end(), arguments.begin() + 1, arguments.end());
  return all;
}

int report(const Outcome& outcome, const CommonOptions& common) {
  if (!common.quiet)
    for (const std::string& warning : outcome.warnings) std::cerr << "warning: " << warning << "\n";
  if (!outcome.trouble.empty()) std::cerr << "bouncelab: " << outcome.trouble << "\n";
  if (common.json)
    std::cout << outcome.summary.dump(2) << "\n";
  else if (!common.quiet)
    std::cout << outcome.text;
  std::cout.flush();
  return outcome.exit_code;
}

/// Parse errors in one line: what, and where help is.
int wrong_usage(const CLI::ParseError& error, const CLI::App& app) {
  const auto parsed = app.get_subcommands();
  const std::string name = parsed.empty() ? "bouncelab" : "bouncelab " + parsed.front()->get_name();
  std::string message = error.what();
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << name << ": " << message << "; see " << name << " --help\n";
  return kWrongUsage;
}

int run(std::vector<std::string> line) {
  CLI::App app{
      "The coefficient of restitution of a bouncing ball: simulated, heard, measured.\n"
      "impact times -> sound -> impact times -> constants; each arrow is a command and a file.",
      "bouncelab"};
  app.set_version_flag("--version", std::string(version()) + " (" + std::string(commit()) + ")");
  app.require_subcommand(1);
  app.set_help_flag("-h,--help", "This help");
  app.option_defaults()->always_capture_default()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);

  CommonOptions common;
  const std::vector<Command> commands{
      // in the order of --help, which is that of the data
      add_simulate_command(app),    add_synthesize_command(app), add_detect_command(app),
      add_restitution_command(app), add_fit_command(app),        add_report_command(app),
      add_calibrate_command(app),   add_analyze_command(app),    add_loop_command(app),
  };
  for (const Command& command : commands) add_common_options(*command.app, common);

  const std::vector<std::string> typed(line.begin() + 1, line.end());
  if (!typed.empty() && typed.front().rfind('-', 0) != 0 &&
      app.get_subcommands([&](const CLI::App* c) { return c->check_name(typed.front()); }).empty())
    throw InvalidArgument("unknown command '" + typed.front() + "'; see bouncelab --help");
  try {
    std::vector<std::string> arguments = with_config(typed, app);
    std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : wrong_usage(error, app);
  }
  notice_interrupts();
  for (const Command& command : commands) {
    if (!command.app->parsed()) continue;
    Run call{common, line, resolved_parameters(*command.app)};
    return report(command.run(call), common);
  }
  return kWrongUsage;
}

}  // namespace
}  // namespace bouncelab::cli

int main(int argc, char** argv) {
  using namespace bouncelab;
  try {
    return cli::run({argv, argv + argc});
  } catch (const Interrupted& error) {
    std::cerr << "bouncelab: " << error.what() << "\n";
    return cli::kInterrupted;
  } catch (const FileError& error) {
    std::cerr << "bouncelab: " << error.what() << "\n";
    return cli::kFileTrouble;
  } catch (const InvalidArgument& error) {
    std::cerr << "bouncelab: " << error.what() << "\n";
    return cli::kWrongUsage;
  } catch (const std::bad_alloc&) {
    std::cerr << "bouncelab: out of memory; ask for less at once\n";
    return cli::kFileTrouble;
  } catch (const std::exception& error) {
    std::cerr << "bouncelab: unexpected error: " << error.what() << "; please report it with the command line\n";
    return cli::kFileTrouble;
  }
}
