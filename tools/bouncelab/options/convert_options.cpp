// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/convert_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command add_convert_command(CLI::App& app) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = app.add_subcommand(
      "convert",
      "Onsets to marks that sound editors show, and marks corrected there back to onsets.\n"
      "By extension: .csv, .jsonl (JSON Lines); .txt (Audacity labels), .svl (Sonic Visualiser), .TextGrid "
      "(Praat), .wav, .rf64 (cue points in a copy of the recording). Labels hold all that is known of an onset "
      "(Audacity's in FILE.txt.onsets.csv beside them), so nothing is lost. A mark that was moved by more than the "
      "format resolves (Audacity 0.5 us; .svl and cues half a sample; .TextGrid 1 ns), or made, counts as it stands, "
      "without standard error, flagged by_hand.");
  command->footer(
      "Example: bouncelab convert onsets.csv --to marks.txt\n"
      "         bouncelab convert marks.txt --recording drop.wav --to corrected.csv");
  command->add_option("input", options->input, "Onsets or marks")->required();
  command->add_option("--to", options->outputs, "Files to write")
      ->type_name("FILE")
      ->required()
      ->expected(1, 100)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--recording", options->recording,
                      "Recording of the marks (Audacity's do not name it); of several in a table, the one to mark");
  command->add_flag("--renumber", options->renumber,
                    "Number the impacts of each drop anew: after marks were taken away, or their intervals stay out");
  return {command, [options](Run& run) { return run_convert(*options, run); }};
}

}  // namespace bouncelab::cli
