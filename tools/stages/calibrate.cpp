// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/calibrate.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "bouncelab/core/error.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"

namespace bouncelab::stages {
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

std::string number(const char* format, std::optional<double> value) {
  return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

/// What the fit with memory states against what it misses, quantity by quantity.
std::string quantities_table(const loop::MemoryCalibrationGroup& group) {
  std::string text = fmt::format("{:9} {:>4} {:>6} {:>6} {:>6} {:>6} {:>9} {:>9} {:>8}\n", "", "n", "pull", "sd", "c68",
                                 "c95", "rms", "rms ind.", "gain");
  for (const loop::MemoryCalibrationRow& r : group.rows)
    text += fmt::format("{:9} {:>4} {:>6} {:>6} {:>6} {:>6} {:>9} {:>9} {:>8}\n", r.quantity, r.n,
                        number("{:.2f}", r.pull_mean), number("{:.2f}", r.pull_sd), number("{:.3f}", r.coverage68),
                        number("{:.3f}", r.coverage95), number("{:.2e}", r.rms_error),
                        number("{:.2e}", r.rms_error_independent), number("{:.3g}", r.gain));
  return text;
}

const loop::MemoryCalibrationRow* row_named(const loop::MemoryCalibrationGroup& group, const std::string& quantity) {
  for (const loop::MemoryCalibrationRow& r : group.rows)
    if (r.quantity == quantity) return &r;
  return nullptr;
}

std::string group_line(const loop::MemoryCalibrationGroup& group) {
  std::string line =
      fmt::format("{:8} {:18} {:>4} {:>6} {:>6}", group.family, group.name, group.n, group.n_failed, group.n_holds);
  for (const char* quantity : {"eps", "q"}) {
    const loop::MemoryCalibrationRow none, *found = row_named(group, quantity), &r = found ? *found : none;
    line += fmt::format(" {:>6} {:>5} {:>5} {:>5}", number("{:.2f}", r.pull_mean), number("{:.2f}", r.pull_sd),
                        number("{:.2f}", r.coverage68), number("{:.2f}", r.coverage95));
  }
  for (const char* quantity : {"eps_025", "eps_060", "eps_120"}) {
    const loop::MemoryCalibrationRow* r = row_named(group, quantity);
    line += fmt::format(" {:>7}", number("{:.3g}", r ? r->gain : std::nullopt));
  }
  return line + "\n";
}

std::string memory_text(const std::vector<loop::MemoryCalibrationGroup>& groups) {
  const auto& any = groups.at(0);
  const auto& passed = groups.at(1);
  std::string text = fmt::format("{} experiments, {} without a fit; the test of the model passes in {}\n", any.n,
                                 any.n_failed, any.n_holds);
  text += "\nWhere the test passes:\n" + quantities_table(passed);
  text += "\nAll fits:\n" + quantities_table(any);
  text += fmt::format(
      "\nWhere the test passes, by group; gain: mean square error of the fit to independent impacts over "
      "that with memory\n{:27} {:>4} {:>6} {:>6} {:^24} {:^24} {:^23}\n",
      "", "", "", "", "eps, three speeds", "q", "gain of eps at");
  text += fmt::format("{:27} {:>4} {:>6} {:>6}", "", "n", "no fit", "passed");
  for (int k = 0; k < 2; ++k) text += fmt::format(" {:>6} {:>5} {:>5} {:>5}", "pull", "sd", "c68", "c95");
  text += fmt::format(" {:>7} {:>7} {:>7}\n", ".25", ".6", "1.2");
  for (std::size_t k = 3; k < groups.size(); ++k) text += group_line(groups[k]);
  return text;
}

Outcome run_memory_calibration(const CalibrateOptions& options, const Run& run) {
  if (!options.out.empty()) check_files(run, {}, {options.out});
  const loop::MemoryCalibrationConfig config = memory_calibration_config(options, run.common);
  const std::vector<loop::MemoryExperiment> experiments =
      loop::calibrate_memory(config, progress_line(run, "calibrate", "experiments"));
  const std::vector<loop::MemoryCalibrationGroup> groups = loop::memory_calibration_groups(experiments);
  if (!options.out.empty()) write_table(run, options.out, to_table(experiments));
  Outcome outcome;
  outcome.text = memory_text(groups);
  outcome.result = summary_of(groups);
  if (groups.front().n_failed == groups.front().n) {
    outcome.exit_code = kNotUsable;
    outcome.error = "no experiment gave a fit with memory: " + report::in_words(experiments.front().objections.front());
  }
  return outcome;
}

}  // namespace

Object summary_of(const std::vector<loop::MemoryCalibrationGroup>& groups) {
  return {{"n_experiments", value_of(groups.front().n)},
          {"n_failed", value_of(groups.front().n_failed)},
          {"groups", value_of(groups)}};
}

fit::CalibrationConfig calibration_config(const CalibrateOptions& options, const CommonOptions& common) {
  fit::CalibrationConfig config = options.config;
  config.seed = common.seed;
  config.n_threads = common.n_threads;
  return config;
}

loop::MemoryCalibrationConfig memory_calibration_config(const CalibrateOptions& options, const CommonOptions& common) {
  loop::MemoryCalibrationConfig config = options.with_memory;
  config.seed = common.seed;
  config.n_threads = common.n_threads;
  const auto drops = [&](std::size_t k) {
    const double n = options.drops[k];
    if (n != std::floor(n)) throw InvalidArgument(fmt::format("--drops {:g}: must be an integer", n));
    return static_cast<std::int64_t>(n);
  };
  config.n_drops_min = drops(0);
  config.n_drops_max = drops(1);
  return config;
}

Outcome run_calibrate(const CalibrateOptions& options, const Run& run) {
  if (options.memory) return run_memory_calibration(options, run);
  const fit::CalibrationConfig config = calibration_config(options, run.common);
  const fit::CalibrationResult result = fit::calibrate(config, progress_line(run, "calibrate", "seeds"));
  Outcome outcome;
  outcome.text = table_of(result);
  outcome.result = object_of(result);
  return outcome;
}

Description members_of(const CalibrateOptions*) {
  using O = CalibrateOptions;
  static constexpr Member options[]{
      member<&O::config, &fit::CalibrationConfig::n_samples>("samples", "Samples per seed").within(100, 1e8),
      member<&O::config, &fit::CalibrationConfig::n_seeds>("seeds", "Seeds").within(2, 1e6),
      member<&O::config, &fit::CalibrationConfig::offset_variance>(
          "offset_variance",
          "Mean square offset of the contact point over the ball's radius, each component: sets the scatter")
          .within(1e-9, 1e-3),
      member<&O::config, &fit::CalibrationConfig::sigma_eps_at_1mps>(
          "timing", "Timing error of eps at 1 m/s; 8.7e-4 is as wide as the scatter at 0.3 m/s")
          .within(0.0, 1.0),
      member<&O::memory>(
          "memory",
          "Instead: the fit with memory and its test on simulated experiments, through sound in every second one, "
          "under conditions drawn at random"),
      member<&O::with_memory, &loop::MemoryCalibrationConfig::n_experiments>("experiments",
                                                                             "With --memory: experiments")
          .within(1, 1e5),
      member<&O::drops>("drops", "With --memory: least and largest number of drops, log-uniform between them")
          .with_commas("LO,HI", 2, 2)
          .within(1.0, 1e4),
      member<&O::with_memory, &loop::MemoryCalibrationConfig::n_impacts>("impacts", "With --memory: impacts of a drop")
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

}  // namespace bouncelab::stages
