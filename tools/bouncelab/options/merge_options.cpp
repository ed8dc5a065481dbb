// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "bouncelab/core/error.hpp"
#include "files/run_parts.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

struct MergeOptions {
  std::vector<std::string> parts;
  std::string out;
};

/// The command that wrote the parts, as it was called but for the shard, and to put the parts together.
/// @param merge  the call of `merge`
Outcome run_from_parts(const AboutRun& about, const std::string& out, std::vector<fs::path> parts, const Run& merge) {
  const auto named = std::find_if(all_commands().begin(), all_commands().end(),
                                  [&](const CommandName& command) { return command.name == about.command; });
  if (named == all_commands().end())
    throw InvalidArgument("the parts are those of '" + about.command + "', which is no command of this version");
  CLI::App app;
  set_option_defaults(app);
  Run call;
  const Command command = named->add(app);
  add_common_options(*command.app, call.common);
  std::vector<std::string> arguments = about.arguments;
  if (!out.empty())  // in front of "--", behind which nothing is an option; the last of several counts
    arguments.insert(std::find(arguments.begin(), arguments.end(), "--"), "--out=" + out);
  try {
    command.app->parse(std::vector<std::string>{arguments.rbegin(), arguments.rend()});
  } catch (const CLI::ParseError& error) {
    throw InvalidArgument("the call of '" + about.command + "' in the parts is not understood: " + error.what());
  }
  call.common.n_threads = merge.common.n_threads;
  call.common.json = merge.common.json;
  call.common.quiet = merge.common.quiet;
  call.common.force = merge.common.force;
  call.command_line = merge.command_line;
  call.parameters = resolved_parameters(*command.app);
  call.arguments = about.arguments;
  call.sweep = about.sweep;
  call.on_progress = merge.on_progress;
  call.command = about.command;
  call.parts = std::move(parts);
  return command.run(call);
}

Outcome run_merge(const MergeOptions& options, const Run& run) {
  std::vector<fs::path> parts = part_files({options.parts.begin(), options.parts.end()});
  const AboutRun about = about_run(parts.front());
  std::string out = options.out;
  if (about.folder != fs::current_path()) {
    // the run's inputs are named as seen from its folder, what is named here as seen from this one
    for (fs::path& part : parts) part = fs::absolute(part);
    if (!out.empty()) out = fs::absolute(out).string();
    std::error_code error;
    fs::current_path(about.folder, error);
    if (error) throw FileError(about.folder.string(), "is the folder in which the parts were made, and is not there");
  }
  return run_from_parts(about, out, std::move(parts), run);
}

}  // namespace

Command add_merge_command(CLI::App& app) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App* command = app.add_subcommand(
      "merge", "Puts the parts of a run together (COMMAND ... --shard I/N): the same files as of the run in one piece");
  command->footer(
      "Example: bouncelab detect *.wav --out onsets.csv --shard 1/2\n"
      "         bouncelab detect *.wav --out onsets.csv --shard 2/2     on another machine, or at the same time\n"
      "         bouncelab merge onsets.csv.parts");
  command->add_option("parts", options->parts, "Folders of parts, or part files")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "In place of the run's own --out");
  return {command, [options](Run& run) { return run_merge(*options, run); }};
}

}  // namespace bouncelab::cli
