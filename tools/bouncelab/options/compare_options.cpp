// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "commands/compare_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command compare_command() {
  using O = CompareOptions;
  static const Description files{
      member("samples", &O::samples,
             "Samples, as restitution writes them, ordered by recording, or recordings: from 2 on")
          .required()
          .positional(),
      member("out", &O::out, "Folder for comparison.json, comparison.csv and report.html")
          .looks_like("FOLDER")
          .required(),
      member("groups", &O::groups,
             "Table of columns recording, plate, date; without it dates in the recordings' names are taken")
          .looks_like("FILE"),
      member("title", &O::title, "Title of the page")};
  static const Description ball = ball_options("not known");
  auto options = std::make_shared<O>();
  return {"compare",
          "Two recordings or plates: do they differ, and by what? Many: the pooled law, drift, plates, outliers",
          "Example: bouncelab compare glass.wav wood.wav --out out/plates\n"
          "         bouncelab compare samples.csv --groups plates.csv --out out/campaign",
          {{"", &files, options.get()}, {"", &ball, &options->restitution.world, {"restitution"}}},
          [options](Run& run) { return run_compare(*options, run); }};
}

}  // namespace bouncelab::cli
