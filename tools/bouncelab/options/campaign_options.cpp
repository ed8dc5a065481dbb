// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "commands/campaign_command.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"

namespace bouncelab::cli {
namespace {

bool is_action(const std::string& word) {
  return word == "start" || word == "status" || word == "resume" || word == "cancel";
}

/// ACTION FILE, or FILE alone, which is to be started.
void tell_apart(CampaignOptions& options) {
  if (options.file.empty() && is_action(options.action))
    throw InvalidArgument("campaign " + options.action + ": which campaign? it takes a file, FILE.toml");
  if (!options.file.empty() && !is_action(options.action))
    throw InvalidArgument("campaign: '" + options.action + "' is none of start, status, resume, cancel");
  if (options.file.empty()) options.file = std::exchange(options.action, "start");
}

}  // namespace

std::vector<loop::SweepAxis> check_options(const std::string& command, const TomlEntries& toml,
                                           const std::string& file) {
  CLI::App app("", "bouncelab");
  set_option_defaults(app);
  CommonOptions common;
  const auto named = std::find_if(all_commands().begin(), all_commands().end(),
                                  [&](const CommandName& c) { return c.name == command; });
  const Command added = named->add(app);
  add_common_options(*added.app, common);
  const auto section = [&](const std::string& name) { return config_section(command, name); };
  const std::vector<ConfigOption> options = config_options(toml, file, *added.app, section);
  std::vector<loop::SweepAxis> axes;
  std::vector<std::string> arguments{command};
  for (const ConfigOption& option : options) {
    if (option.is_axis && command != "loop")
      throw InvalidArgument(option.place + ": '" + option.name + "' takes one value; only loop runs through lists");
    if (option.is_axis) axes.push_back({option.name, option.values});
    const std::size_t n = option.is_axis ? 1 : option.values.size();
    for (std::size_t k = 0; k < n; ++k) arguments.push_back("--" + option.name + "=" + option.values[k]);
  }
  arguments.emplace_back("--out=out");
  for (const CLI::Option* option : added.app->get_options())
    if (option->get_positional() && option->get_required()) arguments.emplace_back("input");
  try {
    app.parse(std::vector<std::string>{arguments.rbegin(), arguments.rend()});
  } catch (const CLI::ParseError& error) {
    std::string place = file;
    for (const ConfigOption& option : options)
      if (std::string(error.what()).rfind("--" + option.name + ":", 0) == 0) place = option.place;
    throw InvalidArgument(place + ": " + error.what() + "; see bouncelab " + command + " --help");
  }
  return axes;
}

Command add_campaign_command(CLI::App& app) {
  auto options = std::make_shared<CampaignOptions>();
  CLI::App* command = app.add_subcommand(
      "campaign",
      "Thousands of recordings, or a large sweep, on a cluster with Slurm or on all cores of this machine\n"
      "  start   divides them into shards and submits these as a job array, their merge behind it; may be left out\n"
      "  status  how many are complete, running, waiting, failed, and why\n"
      "  resume  submits what failed, is missing or has changed\n"
      "  cancel  takes its jobs out of the queue; what is done stays\n"
      "What FILE.toml holds: docs/campaigns.md");
  command->add_option("action", options->action, "start, status, resume or cancel")->required()->default_str("");
  command->add_option("file", options->file, "FILE.toml");
  command->add_option("--on", options->on, "Where it runs; resume goes on where it was started unless this is given")
      ->check(CLI::IsMember({"slurm", "local"}));
  command->add_flag("--dry-run", options->dry_run, "Show the scripts and the command lines; submit and write nothing");
  command->footer(
      "Examples: bouncelab campaign year.toml --on slurm --dry-run\n"
      "          bouncelab campaign year.toml --on slurm\n"
      "          bouncelab campaign status year.toml");
  return {command, [options](Run& run) {
            tell_apart(*options);
            return run_campaign(*options, run);
          }};
}

}  // namespace bouncelab::cli
