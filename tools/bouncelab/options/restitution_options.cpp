// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/ball_of_files.hpp"
#include "stages/restitution.hpp"

namespace bouncelab::cli {

Command restitution_command() {
  using O = RestitutionOptions;
  static const Description files{
      member(
          "onsets", &O::onsets,
          "Onsets, as detect writes them; or marks, or a table of times or intervals from any program. Several files "
          "are taken in this order; rows without a recording are of one that is called like the file")
          .required()
          .positional(),
      member("out", &O::out, "Samples, .csv").looks_like("FILE").required()};
  static const Description ball = ball_options(
      "those of the simulation that the onsets come from (.meta.json), else not known: drag and contact time are then "
      "open");
  auto options = std::make_shared<O>();
  return {"restitution",
          "Coefficients of restitution from impact times: ratios of neighbouring intervals",
          "Example: bouncelab restitution onsets.csv --out samples.csv\n"
          "         bouncelab restitution monday.csv tuesday.csv --out samples.csv",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Marks and tables of other programs", &members_of(&options->foreign), &options->foreign},
           {"Coefficients of restitution", &members_of(options.get()), options.get()}},
          [options](Run& run) {
            *options = with_conditions_of(options->onsets, *options, run);
            return run_restitution(*options, run).outcome;
          }};
}

}  // namespace bouncelab::cli
