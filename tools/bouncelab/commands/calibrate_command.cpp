// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/calibrate_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "bouncelab/fit/calibration.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

struct CalibrateOptions {
  fit::CalibrationConfig config;
  bool covariance_intervals = false;
};

std::string table_of(const fit::CalibrationResult& result) {
  std::string text = fmt::format("{:12} {:>11} {:>9} {:>9} {:>9} {:>7} {:>6} {:>6} {:>6} {:>6}\n", "", "truth", "bound",
                                 "spread", "stated", "st/bnd", "pull", "sd", "c68", "c95");
  for (const fit::CalibrationRow& r : result.rows)
    text += fmt::format("{:12} {:>11.6f} {:>9.2e} {:>9.2e} {:>9.2e} {:>7.3f} {:>6.2f} {:>6.3f} {:>6.3f} {:>6.3f}\n",
                        r.name, r.truth, r.cramer_rao, r.spread, r.mean_se, r.mean_se / r.cramer_rao, r.pull_mean,
                        r.pull_sd, r.coverage68, r.coverage95);
  return text + fmt::format("{} fits did not converge\n", result.n_failed);
}

Json json_of(const fit::CalibrationResult& result) {
  Json rows = Json::array();
  for (const fit::CalibrationRow& r : result.rows)
    rows.push_back({{"name", r.name},
                    {"truth", r.truth},
                    {"cramer_rao", r.cramer_rao},
                    {"spread", r.spread},
                    {"mean_se", r.mean_se},
                    {"pull_mean", r.pull_mean},
                    {"pull_sd", r.pull_sd},
                    {"coverage68", r.coverage68},
                    {"coverage95", r.coverage95}});
  return {{"rows", rows}, {"n_failed", result.n_failed}};
}

Outcome run_calibrate(CalibrateOptions options, Run& run) {
  options.config.seed = run.common.seed;
  options.config.n_threads = run.common.n_threads;
  if (options.covariance_intervals) options.config.intervals = fit::IntervalMethod::covariance;
  const fit::CalibrationResult result = fit::calibrate(options.config, progress_line(run, "calibrate", "seeds"));
  Outcome outcome;
  outcome.text = table_of(result);
  outcome.summary = json_of(result);
  return outcome;
}

}  // namespace

Command add_calibrate_command(CLI::App& app) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command =
      app.add_subcommand("calibrate",
                         "Does the fit keep its word? Pulls, coverage and the Cramer-Rao bound on samples drawn from "
                         "the paper's law\n"
                         "Example: bouncelab calibrate --samples 20000 --seeds 500 --timing 8.7e-4");
  fit::CalibrationConfig& c = options->config;
  command->add_option("--samples", c.n_samples, "Samples per seed")->check(CLI::Range(100, 100000000));
  command->add_option("--seeds", c.n_seeds, "Seeds")->check(CLI::Range(2, 1000000));
  command->add_option("--below", c.below_at_1mps, "Mean distance below the peak at 1 m/s; goes as 1/v")
      ->check(CLI::PositiveNumber);
  command->add_option("--above", c.above_at_1mps, "Mean distance above the peak at 1 m/s")->check(CLI::PositiveNumber);
  command->add_option("--timing", c.sigma_eps_at_1mps, "Timing error of eps at 1 m/s; 8.7e-4 doubles the width")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--covariance-intervals", options->covariance_intervals, "Faster: no profile likelihood");
  return {command, [options](Run& run) { return run_calibrate(*options, run); }};
}

}  // namespace bouncelab::cli
