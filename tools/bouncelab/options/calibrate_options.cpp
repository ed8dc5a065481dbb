// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "bouncelab/core/error.hpp"
#include "commands/calibrate_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

const Description& members_of(const CalibrateOptions*) {
  using O = CalibrateOptions;
  static const Description options{
      member<O>(
          "samples", [](auto& o) -> auto& { return o.config.n_samples; }, "Samples per seed")
          .within(100, 1e8),
      member<O>(
          "seeds", [](auto& o) -> auto& { return o.config.n_seeds; }, "Seeds")
          .within(2, 1e6),
      member<O>(
          "offset_variance", [](auto& o) -> auto& { return o.config.offset_variance; },
          "Mean square offset of the contact point over the ball's radius, each component: sets the scatter")
          .within(1e-9, 1e-3),
      member<O>(
          "timing", [](auto& o) -> auto& { return o.config.sigma_eps_at_1mps; },
          "Timing error of eps at 1 m/s; 8.7e-4 is as wide as the scatter at 0.3 m/s")
          .within(0.0, 1.0),
      member("memory", &O::memory,
             "Instead: the fit with memory and its test on simulated experiments, through sound in every second one, "
             "under conditions drawn at random"),
      member<O>(
          "experiments", [](auto& o) -> auto& { return o.with_memory.n_experiments; }, "With --memory: experiments")
          .within(1, 1e5),
      member("drops", &O::drops, "With --memory: least and largest number of drops, log-uniform between them")
          .with_commas("LO,HI", 2, 2)
          .within(1.0, 1e4),
      member<O>(
          "impacts", [](auto& o) -> auto& { return o.with_memory.n_impacts; }, "With --memory: impacts of a drop")
          .within(12, 1000)};
  return options;
}

void check_calibrate_options(const CalibrateOptions& options, const Given& given) {
  const auto refuse_where_given = [&](const std::vector<const char*>& names, const char* why) {
    for (const char* name : names)
      if (given.contains(name)) throw InvalidArgument(std::string("--") + name + why);
  };
  if (options.memory)
    refuse_where_given({"samples", "seeds", "offset-variance", "timing"},
                       ": not with --memory, which has --experiments, --drops and --impacts");
  else
    refuse_where_given({"experiments", "drops", "impacts", "out"}, ": only with --memory");
}

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
