// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/printable.hpp"
#include "bouncelab/core/version.hpp"
#include "command.hpp"
#include "options/command_line.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

bool is_command(const std::vector<std::string>& typed) {
  return !typed.empty() && std::any_of(all_commands().begin(), all_commands().end(),
                                       [&](const CommandName& command) { return command.name == typed.front(); });
}

/// One line on standard error, whatever it quotes.
void say(const std::string& message) { std::cerr << printable(message, kMessage_characters) << "\n"; }

/// Ends as other programs do whose reader has gone (`| head`).
[[noreturn]] void end_by_broken_pipe() {
  std::signal(SIGPIPE, SIG_DFL);
  std::raise(SIGPIPE);
  std::exit(kFileError);
}

/// @return the exit code: that of the work, unless its result could not be said
int print(const std::string& text, int exit_code) {
  const int error = write_to_standard_output(text);
  if (error == EPIPE) end_by_broken_pipe();
  if (error == 0) return exit_code;
  say("bouncelab: standard output: writing failed: " + std::string(std::strerror(error)));
  return kFileError;
}

/// Options whose values are files that are written.
const std::vector<std::string> kOutputOptions{"out", "labels", "truth", "write-surface", "table", "to"};

bool is_taken_by_an_output(const Parameters& parameters) {
  return std::any_of(parameters.begin(), parameters.end(), [](const Parameter& p) {
    return std::find(kOutputOptions.begin(), kOutputOptions.end(), p.name) != kOutputOptions.end() &&
           std::any_of(p.values.begin(), p.values.end(),
                       [](const std::string& value) { return !value.empty() && is_standard_output(value); });
  });
}

/// @param standard_output_is_taken  by a table, which a summary must not be mixed with
int report(const Outcome& outcome, const CommonOptions& common, bool standard_output_is_taken) {
  if (!common.quiet)
    for (const std::string& warning : outcome.warnings) say("warning: " + warning);
  if (!outcome.error.empty()) say("bouncelab: " + outcome.error);
  if (common.json) return print(outcome.json + "\n", outcome.exit_code);
  if (common.quiet || outcome.text.empty()) return outcome.exit_code;
  if (!standard_output_is_taken) return print(outcome.text, outcome.exit_code);
  std::cerr << outcome.text;
  return outcome.exit_code;
}

/// A descriptor that is closed would be given to the next file that is opened, which standard output would then be
/// written into. One that cannot be read, or written, makes that an error as before.
void keep_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(descriptor, F_GETFD) < 0)
      (void)!::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY);  // takes the lowest that is free
}

/// The memory manager gives each thread an arena of its own, 64 MB of address space, and where a limit leaves no room
/// for one it asks the system at every allocation, a hundred times as slow. Under a limit all threads share one.
void share_memory_under_a_limit() {
#ifdef M_ARENA_MAX
  rlimit address_space{};
  if (::getrlimit(RLIMIT_AS, &address_space) == 0 && address_space.rlim_cur != RLIM_INFINITY) ::mallopt(M_ARENA_MAX, 1);
#endif
}

/// What is freed in pieces above a megabyte goes back to the system, and what is free above 4 MB at the end of the
/// heap. By itself glibc keeps all that is below the largest freed so far: a fifth more memory for an hour of music.
void give_large_memory_back() {
#ifdef M_MMAP_THRESHOLD
  ::mallopt(M_MMAP_THRESHOLD, 1 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 22);
#endif
}

/// The message with every long or unprintable word of the command line as quotations show it.
std::string with_quotations(std::string message, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const std::string value = word.substr(word.find('=') + 1);  // of --option=value, else the word
    const std::string shown = printable(value);
    const auto at = shown == value ? std::string::npos : message.find(value);
    if (at != std::string::npos) message.replace(at, value.size(), shown);
  }
  return message;
}

/// Parse errors in one line: what, where in the configuration file, and where help is.
int wrong_usage(const CLI::ParseError& error, const CLI::App& app, const CommandLine& line) {
  const auto parsed = app.get_subcommands();
  const std::string name = parsed.empty() ? "bouncelab" : "bouncelab " + parsed.front()->get_name();
  std::string message = with_quotations(error.what(), line.arguments);
  for (const ConfigOption& option : line.from_file)
    if (message.rfind("--" + option.name + ":", 0) == 0) message.insert(0, option.place + ": ");
  std::replace(message.begin(), message.end(), '\n', ' ');
  say(name + ": " + printable(message, kMessage_characters - 100) + "; see " + name + " --help");
  return kWrongUsage;
}

int run(std::vector<std::string> line) {
  CLI::App app{
      "The coefficient of restitution of a bouncing ball: simulated, detected in sound, measured.\n"
      "impact times -> sound -> impact times -> constants; each arrow is a command and a file.",
      "bouncelab"};
  app.set_version_flag("--version", std::string(version()) + " (" + std::string(commit()) + ")");
  app.require_subcommand(1);
  app.set_help_flag("-h,--help", "This help");
  set_option_defaults(app);

  CommonOptions common;
  const std::vector<std::string> typed(line.begin() + 1, line.end());
  std::vector<Command> commands;
  for (const auto& [name, add] : all_commands())
    // registering the options of all commands takes as long as detection in a second of sound
    if (!is_command(typed) || typed.front() == name) commands.push_back(add(app));
  for (const Command& command : commands) add_common_options(*command.app, common);

  if (!typed.empty() && typed.front().rfind('-', 0) != 0 && !is_command(typed))
    throw InvalidArgument("unknown command '" + typed.front() + "'; see bouncelab --help");
  CommandLine full;
  try {
    full = is_command(typed) ? line_with_config(typed, *app.get_subcommand(typed.front())) : CommandLine{typed, {}};
    app.parse(
        std::vector<std::string>{full.arguments.rbegin(), full.arguments.rend()});  // CLI11 takes them from the back
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return wrong_usage(error, app, full);
    std::ostringstream help;
    return print((app.exit(error, help, help), help.str()), kDone);
  }
  for (const Command& command : commands) {
    if (!command.app->parsed()) continue;
    Run call{common, line, resolved_parameters(*command.app), {}, {}};
    call.arguments.assign(full.arguments.begin() + 1, full.arguments.end());
    for (const ConfigOption& option : full.from_file)
      if (option.is_axis) call.sweep.push_back({option.name, option.values});
    const bool standard_output_is_taken = is_taken_by_an_output(call.parameters);
    if (standard_output_is_taken && common.json)
      throw InvalidArgument("--json: standard output takes an output of this command; write that to a file");
    Outcome outcome;
    // one pool of threads for all loops of the command: pools made one after the other overlap while the old one ends
    with_threads(common.n_threads, [&] { outcome = command.run(call); });
    return report(outcome, common, standard_output_is_taken);
  }
  return kWrongUsage;
}

}  // namespace
}  // namespace bouncelab::cli

int main(int argc, char** argv) {
  using namespace bouncelab;
  cli::share_memory_under_a_limit();
  cli::give_large_memory_back();
  cli::keep_standard_descriptors();
  cli::notice_signals();
  try {
    return cli::run({argv, argv + argc});
  } catch (const Interrupted& error) {
    cli::say("bouncelab: " + std::string(error.what()));
    return cli::kInterrupted;
  } catch (const BrokenPipe&) {
    cli::end_by_broken_pipe();
  } catch (const FileExists& error) {
    cli::say("bouncelab: " + std::string(error.what()) + "; --force replaces it");
    return cli::kFileError;
  } catch (const FileError& error) {
    cli::say("bouncelab: " + std::string(error.what()));
    return cli::kFileError;
  } catch (const InvalidArgument& error) {
    cli::say("bouncelab: " + std::string(error.what()));
    return cli::kWrongUsage;
  } catch (const std::filesystem::filesystem_error& error) {
    cli::say("bouncelab: " + error.path1().string() + ": " + error.code().message());
    return cli::kFileError;
  } catch (const std::bad_alloc&) {
    cli::say("bouncelab: out of memory; ask for less at once");
    return cli::kFileError;
  } catch (const std::exception& error) {
    cli::say("bouncelab: unexpected error: " + printable(error.what(), kMessage_characters - 100) +
             "; please report it with the command line");
    return cli::kFileError;
  }
}
