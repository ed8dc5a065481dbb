// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/notes.hpp"
#include "options/commands.hpp"
#include "stages/run.hpp"

namespace bouncelab::cli {
namespace {

/// The one line for a process that is out of memory, without asking for any.
void say_out_of_memory() noexcept {
  constexpr std::string_view kMessage = "bouncelab: out of memory; ask for less at once\n";
  (void)!::write(STDERR_FILENO, kMessage.data(), kMessage.size());
}

/// Where nothing may be thrown a shortage ends the process: destructors (nlohmann::json's, Ceres' timers) ask for
/// memory.
[[noreturn]] void end_of_process() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    say_out_of_memory();
    std::_Exit(kFileError);
  } catch (...) {  // NOLINT(bugprone-empty-catch): the process is ended below
  }
  std::abort();
}

bool is_command(const std::vector<std::string>& typed) {
  return !typed.empty() && command_named(all_commands(), typed.front()) != nullptr;
}

/// The arguments, with those in full that people write short: nothing asks for help, as does `help COMMAND`; recordings
/// alone are to be analyzed.
std::vector<std::string> in_full(std::vector<std::string> typed) {
  if (typed.empty()) return {"--help"};
  if (typed.front() == "help") {
    typed.erase(typed.begin());
    typed.emplace_back("--help");
  } else if (!is_command(typed) && (typed.front() == "-" || std::filesystem::exists(typed.front()))) {
    typed.insert(typed.begin(), "analyze");
  }
  return typed;
}

/// What `typed`, which is no command, was probably meant to be.
std::string unknown_command(const std::string& typed) {
  if (typed.find_first_of("./") != std::string::npos) return "no such file or command '" + typed + "'";
  if (typed == "calibrate")
    return "'calibrate' is no command any more; samples/calibration.py of the source does it by the Python module";
  std::vector<std::string> names;
  for (const Command& command : all_commands()) names.push_back(command.name);
  const std::string nearest = nearest_name(typed, names);
  return "unknown command '" + typed + "'" +
         (nearest.empty() ? "; see bouncelab --help" : "; did you mean '" + nearest + "'?");
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

bool is_taken_by_an_output(const Parameters& parameters) {
  return std::any_of(parameters.begin(), parameters.end(), [](const Parameter& p) {
    return p.is_output && std::any_of(p.values.begin(), p.values.end(), [](const std::string& value) {
             return !value.empty() && is_standard_output(value);
           });
  });
}

/// Lines of a summary, in which a file's name does nothing to the terminal.
std::string harmless(std::string_view text) {
  std::string safe;
  while (!text.empty()) {
    const std::size_t n = std::min(text.find_first_of("\n\t"), text.size());
    safe += printable(text.substr(0, n), std::max(n * 4, kMessage_characters));  // four characters for a byte: not cut
    if (n < text.size()) safe += text[n];
    text.remove_prefix(std::min(n + 1, text.size()));
  }
  return safe;
}

/// Of very many the first.
std::vector<std::string> warnings_of(const std::vector<Note>& notes) {
  constexpr std::size_t kMostLines = 20;
  std::vector<std::string> lines = report::texts_of(notes, Severity::warning);
  if (lines.size() <= kMostLines) return lines;
  const std::size_t n_more = lines.size() - kMostLines;
  lines.resize(kMostLines);
  lines.push_back("... and " + std::to_string(n_more) + " more; with --json all of them are listed");
  return lines;
}

/// @param standard_output_is_taken  by a table, which a summary must not be mixed with
int report(const Outcome& outcome, const CommonOptions& common, bool standard_output_is_taken) {
  if (!common.quiet)
    for (const std::string& warning : warnings_of(outcome.notes)) say("warning: " + warning);
  if (!outcome.error.empty()) say("bouncelab: " + outcome.error);
  if (common.json) {
    Object result = outcome.result;
    if (!outcome.error.empty()) {
      result.emplace_back("error", outcome.error);
      result.emplace_back("exit_code", value_of(outcome.exit_code));
    }
    return print(json_text(result, 2) + "\n", outcome.exit_code);
  }
  if (common.quiet || outcome.text.empty()) return outcome.exit_code;
  if (!standard_output_is_taken) return print(harmless(outcome.text), outcome.exit_code);
  std::cerr << harmless(outcome.text);
  return outcome.exit_code;
}

/// A descriptor that is closed would be given to the next file that is opened, which standard output would then be
/// written into. One that cannot be read, or written, makes that an error as before.
void keep_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(descriptor, F_GETFD) < 0)
      (void)!::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY);  // takes the lowest that is free
}

/// The command with what is typed and what its configuration file sets.
/// @param json  whether failures are told as JSON, once it is known
int run_command(const Command& command, const std::vector<std::string>& typed, const std::vector<std::string>& line,
                bool& json) {
  Run call;
  call.command_line = line;
  const std::vector<Section> sections = all_sections(command, call.common);
  const CommandLine full = line_with_config(typed, command, all_commands());
  try {
    call.given = set_options(sections, {full.arguments.begin() + 1, full.arguments.end()});
  } catch (const WrongUsage& error) {
    const std::string name = "bouncelab " + command.name;
    std::string message = error.what();
    for (const ConfigOption& option : full.from_file)
      if (message.rfind("--" + option.name + ":", 0) == 0) message.insert(0, option.place + ": ");
    throw WrongUsage(name + ": " + printable(message, kMessage_characters - 100) + "; see " + name + " --help");
  }
  json = call.common.json;
  if (command.prepare) command.prepare(call.given);
  call.parameters = parameters_of(sections, call.given);
  for (const ConfigOption& option : full.from_file)
    if (option.is_axis) call.sweep.push_back({option.name, option.values});
  const bool standard_output_is_taken = is_taken_by_an_output(call.parameters);
  if (standard_output_is_taken && call.common.json)
    throw InvalidArgument("--json: standard output takes an output of this command; write that to a file");
  Outcome outcome;
  // one pool of threads for all loops of the command: pools made one after the other overlap while the old one ends
  with_threads(call.common.n_threads, [&] { outcome = command.run(call); });
  return report(outcome, call.common, standard_output_is_taken);
}

int run(const std::vector<std::string>& line, bool& json) {
  const std::vector<std::string> typed = in_full({line.begin() + 1, line.end()});
  const auto end = std::find(typed.begin(), typed.end(), "--");
  const auto asks_for = [&](const char* option) { return std::find(typed.begin(), end, option) != end; };
  if (is_command(typed)) {
    const std::vector<Command> all = all_commands();
    const Command& command = *command_named(all, typed.front());
    if (asks_for("--help") || asks_for("-h")) return print(help_of(command, false), kDone);
    if (asks_for("--help-all")) return print(help_of(command, true), kDone);
    return run_command(command, typed, line, json);
  }
  if (asks_for("--help") || asks_for("-h")) return print(help_of_all(), kDone);
  if (typed.front() == "--version") return print(std::string(version()) + " (" + std::string(commit()) + ")\n", kDone);
  if (typed.front().rfind('-', 0) == 0)
    throw WrongUsage("bouncelab: unknown option '" + printable(typed.front()) + "'; see bouncelab --help");
  throw InvalidArgument(unknown_command(typed.front()));
}

/// With --json whoever reads standard output learns of the failure there too.
int fail(const std::string& message, int exit_code, bool json) {
  say(message);
  return json ? print(json_text(Object{{"error", message}, {"exit_code", value_of(exit_code)}}, 2) + "\n", exit_code)
              : exit_code;
}

/// Can what a table holds be said to the command that was typed?
bool takes_columns(const std::vector<std::string>& line) {
  const std::vector<Command> all = all_commands();
  const Command* command = command_named(all, in_full({line.begin() + 1, line.end()}).front());
  return command != nullptr && option_named(command->sections, "columns");
}

/// The columns of a table that does not prove what it holds, and the command that was typed with each answer; that
/// which makes times of it where the one that was typed takes no answer.
void say_readings(const AmbiguousTable& table, const std::vector<std::string>& line) {
  std::size_t widest = 0;
  for (const AmbiguousTable::Column& column : table.columns()) widest = std::max(widest, column.title.size());
  for (const AmbiguousTable::Column& column : table.columns())
    say("    " + column.title + std::string(widest - column.title.size() + 2, ' ') + column.first_cells + " ...");
  std::string command = "bouncelab", out;
  if (takes_columns(line)) {
    for (std::size_t k = 1; k < line.size(); ++k) {
      const bool is_answer = line[k] == "--as" || line[k] == "--unit" || line[k] == "--columns";
      if (is_answer)
        ++k;
      else
        command += " " + shell_word(line[k]);
    }
  } else {
    command += " convert " + shell_word(table.file());
    out = " --to " + shell_word(table.file() + ".times.csv");
  }
  const bool takes_speeds = out.empty() && line[1] != "convert";  // which have no times
  for (const AmbiguousTable::Reading& reading : table.readings())
    if (takes_speeds || !reading.options.tells_speeds())
      say("  " + reading.meaning + ": " + command + " " + command_line_of(reading.options) + out);
}

/// @return the exit code, after one line of what went wrong
int run_and_report(const std::vector<std::string>& line) {
  bool json = std::find(line.begin(), std::find(line.begin(), line.end(), "--"), "--json") != line.end();
  try {
    return run(line, json);
  } catch (const Interrupted& error) {
    return fail("bouncelab: " + std::string(error.what()), kInterrupted, json);
  } catch (const WrongUsage& error) {
    return fail(error.what(), kWrongUsage, json);
  } catch (const FileExists& error) {
    return fail("bouncelab: " + std::string(error.what()) + "; --force replaces it", kFileError, json);
  } catch (const FileError& error) {
    return fail("bouncelab: " + std::string(error.what()), kFileError, json);
  } catch (const AmbiguousTable& error) {
    const int exit_code =
        fail("bouncelab: " + (json && takes_columns(line) ? std::string(error.what()) : error.question()), kWrongUsage,
             json);
    say_readings(error, line);
    return exit_code;
  } catch (const InvalidArgument& error) {
    return fail("bouncelab: " + std::string(error.what()), kWrongUsage, json);
  } catch (const std::filesystem::filesystem_error& error) {
    return fail("bouncelab: " + error.path1().string() + ": " + error.code().message(), kFileError, json);
  } catch (const std::bad_alloc&) {
    return fail("bouncelab: out of memory; ask for less at once", kFileError, json);
  } catch (const std::exception& error) {
    return fail("bouncelab: unexpected error: " + printable(error.what(), kMessage_characters - 100) +
                    "; please report it with the command line",
                kFileError, json);
  }
}

}  // namespace
}  // namespace bouncelab::cli

int main(int argc, char** argv) try {
  using namespace bouncelab;
  std::set_terminate(cli::end_of_process);
  cli::keep_standard_descriptors();
  cli::notice_signals();
  return cli::run_and_report({argv, argv + argc});
} catch (const std::bad_alloc&) {  // before the work began, or while its failure was said
  bouncelab::cli::say_out_of_memory();
  return bouncelab::cli::kFileError;
}
