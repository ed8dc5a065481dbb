// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/roughness.hpp"

namespace bouncelab::cli {

Command roughness_command() {
  using O = RoughnessOptions;
  static const Description files{
      member("samples", &O::samples,
             "Samples of one ball, as restitution writes them: 60 impacts or more, drops of 10 successive ones")
          .required()
          .positional(),
      member("out", &O::out, "Also the results, .json").looks_like("FILE")};
  static const Description ball = ball_options("what the samples say, else a solid ball of the paper's radius");
  auto options = std::make_shared<O>();
  return {
      "roughness",
      "The roughness of a ball from the scatter of its coefficients of restitution: q, and surfaces that scatter so",
      "Example: bouncelab roughness samples.csv\n"
      "         bouncelab roughness shell.csv --ball table-tennis --out roughness.json",
      {{"", &files, options.get()},
       {"", &ball, &options->world},
       {"", &members_of(&options->config), &options->config}},
      [options](Run& run) { return run_roughness(*options, run); }};
}

}  // namespace bouncelab::cli
