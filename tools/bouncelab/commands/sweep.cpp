// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/sweep.hpp"

#include <filesystem>
#include <map>

#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "commands/report_command.hpp"
#include "files/run_parts.hpp"
#include "files/table_file.hpp"
#include "json/loop_json.hpp"
#include "loop_text.hpp"
#include "options/commands.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kOutputs{"sweep.csv", "sweep.json", "report.html"};

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

std::string item_name(std::size_t point) { return "point " + std::to_string(point); }

/// The points of the shard, kept in its part.
Outcome run_part(const LoopOptions& options, const std::vector<std::string>& items, const Run& run) {
  PartFile part(run, options.out, loop_identity(options, run), items);
  const ProgressCallback progress = progress_line(run, "sweep", "points");
  const auto total = static_cast<double>(part.pending().size());
  double n_done = 0.0;
  for (const std::size_t k : part.pending()) {
    progress(n_done++, total);
    part.keep(k, to_record(k, run_point(run, loop::combination(run.sweep, k))));
  }
  return part.finish(simulation_inputs(options.simulate), "points");
}

}  // namespace

Outcome run_sweep(const LoopOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const std::size_t n_points = loop::n_combinations(run.sweep);
  for (std::size_t k = 0; k < n_points; ++k) parsed(run, loop::combination(run.sweep, k));  // errors before the work

  std::vector<std::string> items;
  for (std::size_t k = 0; k < n_points; ++k) items.push_back(item_name(k));
  if (run.shard) return run_part(options, items, run);

  const OutputFolder output_folder(folder);
  std::map<std::size_t, loop::SweepPoint> finished;
  const auto take = [&](const std::string&, std::string_view record) {
    loop::NumberedPoint numbered = loop::point_from_record(record);
    finished[numbered.index] = std::move(numbered.point);
  };
  const auto journal = open_journal(options, kOutputs, run, take);
  if (!run.parts.empty()) {
    RunParts parts(run, loop_identity(options, run), items);
    for (std::size_t k = 0; k < parts.size(); ++k) take(items[k], parts.record(k));
  }

  const ProgressCallback progress = progress_line(run, "sweep", "points");
  std::vector<loop::SweepPoint> points;
  for (std::size_t k = 0; k < n_points; ++k) {
    progress(static_cast<double>(k), static_cast<double>(n_points));
    if (finished.count(k) == 0) {
      finished[k] = run_point(run, loop::combination(run.sweep, k));
      journal->append(items[k], to_record(k, finished[k]));
    }
    points.push_back(finished[k]);
  }

  const Run own = replacing(run);  // what lies in the folder is this run's own
  write_table(own, folder / "sweep.csv", to_table(points));
  write_text(own, folder / "sweep.json", sweep_json(run.sweep, points, 1) + "\n");
  const Outcome shown = run_report({folder, folder / "report.html", "Sweep: results for each combination"}, own);
  if (journal) journal->remove();
  return {kDone, sweep_json(run.sweep, points, 2), sweep_text(points) + shown.text, {}, ""};
}

}  // namespace bouncelab::cli
