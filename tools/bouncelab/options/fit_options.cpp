// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/fit.hpp"

namespace bouncelab::cli {

Command fit_command() {
  using O = FitOptions;
  static const Description files{
      member("samples", &O::samples,
             "Samples; columns v_mps and eps are enough, or a table of speeds and eps from elsewhere. Recordings, by "
             "the column `recording` or else by the name of "
             "the file, are tested for agreement; where two files have the same drop of the same recording, they are "
             "two recordings")
          .required()
          .positional(),
      member("out", &O::out, "Results, .json").looks_like("FILE").required(),
      member("columns", &O::columns, "Which columns of a table from elsewhere are what (default: by their titles)")
          .looks_like("v=COLUMN,eps=COLUMN"),
      member("table", &O::table, "Also the law as a table v_mps, eps, lo95, hi95").looks_like("FILE"),
      member("histograms", &O::histograms, "Also p(eps) in windows of speed: bins, counts, density with its error, fit")
          .looks_like("FILE")};
  static const Description ball = ball_options("what the samples say");
  auto options = std::make_shared<O>();
  return {"fit",
          "The law eps(v) and the histograms p(eps) from coefficients of restitution",
          "Example: bouncelab fit samples.csv --out fit.json\n"
          "         bouncelab fit ball_a.csv ball_b.csv --out fit.json",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Fit", &members_of(&options->config), &options->config}},
          [options](Run& run) { return run_fit(*options, run).outcome; }};
}

}  // namespace bouncelab::cli
