// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "commands/convert_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command convert_command() {
  using O = ConvertOptions;
  static const Description files{
      member("input", &O::input, "Onsets, or marks or times of any program").required().positional(),
      member("to", &O::outputs, "Files to write").looks_like("FILE").required(),
      member<O>(
          "recording", [](auto& o) -> auto& { return o.foreign.recording; },
          "Recording of the marks (Audacity's do not name it); of several in a table, the one to mark"),
      member<O>(
          "renumber", [](auto& o) -> auto& { return o.foreign.renumber; },
          "Number the impacts of each drop anew: after marks were taken away, or their intervals stay out")};
  auto options = std::make_shared<O>();
  return {"convert",
          "Onsets to marks that sound editors show, and marks corrected there back to onsets.\n"
          "Written by extension: .csv, .jsonl (JSON Lines); .txt (Audacity labels), .svl (Sonic Visualiser), .TextGrid "
          "(Praat), .wav, .rf64 (cue points in a copy of the recording). Labels hold all that is known of an onset "
          "(Audacity's in FILE.txt.onsets.csv beside them), so nothing is lost. A mark that was moved by more than the "
          "format resolves (Audacity 0.5 us; .svl and cues half a sample; .TextGrid 1 ns), or made, counts as it "
          "stands, without standard error, flagged by_hand.",
          "Example: bouncelab convert onsets.csv --to marks.txt\n"
          "         bouncelab convert marks.txt --recording drop.wav --to corrected.csv",
          {{"", &files, options.get()},
           {"Marks and tables of other programs", &members_of(&options->foreign), &options->foreign}},
          [options](Run& run) { return run_convert(*options, run); }};
}

}  // namespace bouncelab::cli
