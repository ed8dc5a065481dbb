// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>

#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "options/commands.hpp"
#include "stages/files/table_file.hpp"
#include "stages/loop.hpp"
#include "stages/loop_results.hpp"
#include "stages/progress_line.hpp"
#include "stages/report.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kOutputsOfASweep{"sweep.csv", "sweep.json", "report.html"};

/// A command line of `loop` on its own.
struct ParsedLoop {
  LoopOptions options;
  CommonOptions common;
};

/// @throws InvalidArgument saying what is wrong with the arguments
ParsedLoop parse_loop(const std::vector<std::string>& arguments) {
  ParsedLoop parsed;
  Run run;
  std::vector<Section> sections = loop_sections(parsed.options);
  sections.push_back(common_section(parsed.common));
  try {
    run.given = set_options(sections, arguments);
  } catch (const WrongUsage& error) {
    throw InvalidArgument(error.what());
  }
  apply_loop_preset(parsed.options, run);
  return parsed;
}

/// The loop's configuration with these settings, but for a surface from a file.
/// @throws InvalidArgument naming the settings
ParsedLoop parsed(const Run& run, const loop::Settings& settings) {
  std::vector<std::string> arguments = run.arguments;
  for (const auto& [option, value] : settings) arguments.push_back("--" + option + "=" + value);
  try {
    ParsedLoop loop = parse_loop(arguments);
    loop_config(loop.options, loop.common);
    return loop;
  } catch (const InvalidArgument& error) {
    throw InvalidArgument("sweep, " + loop::text_of(settings) + ": " + error.what());
  }
}

loop::SweepPoint run_point(const Run& run, const loop::Settings& settings) {
  const ParsedLoop loop = parsed(run, settings);
  loop::LoopConfig config = loop_config(loop.options, loop.common);
  config.surface = surface_from_file(loop.options.simulate, config.simulation.ball);
  return loop::sweep_point(settings, loop::run_loop(config, interrupts_only), config.node_speeds_mps);
}

}  // namespace

Outcome run_sweep(const LoopOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const std::size_t n_points = loop::n_combinations(run.sweep);
  for (std::size_t k = 0; k < n_points; ++k) parsed(run, loop::combination(run.sweep, k));  // errors before the work

  const OutputFolder output_folder(folder);
  check_loop_files(options, kOutputsOfASweep, run);
  const ProgressCallback progress = progress_line(run, "sweep", "points");
  std::vector<loop::SweepPoint> points;
  for (std::size_t k = 0; k < n_points; ++k) {
    progress(static_cast<double>(k), static_cast<double>(n_points));
    points.push_back(run_point(run, loop::combination(run.sweep, k)));
  }

  const std::vector<fs::path> inputs = files_named_by_options(run);
  write_table(run, folder / "sweep.csv", to_table(points), inputs);
  Object lists;
  for (const loop::SweepAxis& axis : run.sweep) lists.emplace_back(axis.option, axis.values);
  const Object sweep{{"lists", lists}, {"points", value_of(points)}};
  write_text(run, folder / "sweep.json", json_text(sweep, 1) + "\n", inputs);
  const Outcome shown = run_report({folder, folder / "report.html", "Sweep: results for each combination"}, run);
  return {kDone, sweep, sweep_text(points) + shown.text, {}, ""};
}

}  // namespace bouncelab::cli
