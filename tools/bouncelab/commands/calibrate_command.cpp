// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/calibrate_command.hpp"

#include <fmt/format.h>

#include "json/stage_json.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

std::string table_of(const fit::CalibrationResult& result) {
  std::string text = fmt::format("{:12} {:>11} {:>9} {:>9} {:>9} {:>7} {:>6} {:>6} {:>6} {:>6}\n", "", "truth",
                                 "ind.bound", "spread", "stated", "st/ind", "pull", "sd", "c68", "c95");
  for (const fit::CalibrationRow& r : result.rows)
    text += fmt::format("{:12} {:>11.6f} {:>9.2e} {:>9.2e} {:>9.2e} {:>7.3f} {:>6.2f} {:>6.3f} {:>6.3f} {:>6.3f}\n",
                        r.name, r.truth, r.bound_independent, r.spread, r.mean_se, r.mean_se / r.bound_independent,
                        r.pull_mean, r.pull_sd, r.coverage68, r.coverage95);
  return text + fmt::format("{} fits did not converge\n", result.n_failed);
}

}  // namespace

Outcome run_calibrate(const CalibrateOptions& options, const Run& run) {
  fit::CalibrationConfig config = options.config;
  config.seed = run.common.seed;
  config.n_threads = run.common.n_threads;
  if (options.covariance_intervals) config.intervals = fit::IntervalMethod::covariance;
  const fit::CalibrationResult result = fit::calibrate(config, progress_line(run, "calibrate", "seeds"));
  Outcome outcome;
  outcome.text = table_of(result);
  outcome.json = calibrate_json(result);
  return outcome;
}

}  // namespace bouncelab::cli
