// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/calibrate.hpp"

namespace bouncelab::cli {

Command calibrate_command() {
  using O = CalibrateOptions;
  static const Description files{
      member("out", &O::out, "With --memory: table of the experiments, .csv").looks_like("FILE")};
  auto options = std::make_shared<O>();
  return {"calibrate",
          "Calibration of the fit: pulls and coverage on drops of a rough ball drawn from the paper's law, and the "
          "Cramer-Rao bound of independent samples",
          "Examples: bouncelab calibrate --samples 20000 --seeds 500 --timing 8.7e-4\n"
          "          bouncelab calibrate --memory --experiments 200 --out experiments.csv",
          {{"", &members_of(options.get()), options.get()}, {"", &files, options.get()}},
          [options](Run& run) {
            check_calibrate_options(*options, run.given);
            return run_calibrate(*options, run);
          }};
}

}  // namespace bouncelab::cli
