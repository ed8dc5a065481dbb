// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "bouncelab/core/files.hpp"
#include "bouncelab/loop/loop_score.hpp"
#include "bouncelab/sim/sim.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

std::string text_of(const SimulateOptions& options, const sim::SimulationConfig& config,
                    const sim::SimulationResult& result) {
  const sim::EnergyLedger& energy = result.energy;
  return fmt::format(
      "{} impacts of {} drops in {} ({:.1f}% of them on the smooth sphere)\n"
      "ball: {}\n"
      "law: {}; contact: {}\n"
      "energy: released {:.4g} J, dissipated {:.2f}%, created {:.3g}%, still in the balls {:.2f}%\n",
      result.n_impacts, config.n_drops, options.out,
      100.0 * static_cast<double>(result.n_smooth) / static_cast<double>(std::max<std::int64_t>(1, result.n_impacts)),
      bouncelab::describe(config.ball), describe(config.law), describe(config.contact), energy.released_j,
      100.0 * energy.dissipated_j / energy.released_j, 100.0 * energy.created_j / energy.released_j,
      100.0 * energy.remaining_j / energy.released_j);
}

}  // namespace

std::vector<std::filesystem::path> simulation_inputs(const SimulateOptions& options) {
  std::vector<std::filesystem::path> inputs;
  if (!options.surface_file.empty()) inputs.emplace_back(options.surface_file);
  const std::string table = "table:";
  if (options.restitution_law.starts_with(table)) inputs.emplace_back(options.restitution_law.substr(table.size()));
  return inputs;
}

std::optional<sim::Surface> surface_from_file(const SimulateOptions& options, const Ball& ball) {
  if (options.surface_file.empty()) return std::nullopt;
  return sim::surface_from_table(read_table(options.surface_file, sim::surface_columns()),
                                 input_name(options.surface_file), ball);
}

sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config, const Run& run) {
  if (std::optional<sim::Surface> given = surface_from_file(options, config.ball)) return *std::move(given);
  return sim::make_surface(config.ball, options.n_asperities, sim::radius_law_from_text(options.radius_law),
                           config.seed, progress_line(run, "surface", "asperities"));
}

Object summary_of(const sim::SimulationResult& result, const Ball& ball) {
  Object summary = object_of(result);
  summary.emplace_back("ball", value_of(ball));
  return summary;
}

void prepare(SimulateOptions& options, const Given& given) {
  if (options.preset != "paper") return;
  if (!given.contains("drops")) options.config.n_drops = loop::kPaperDrops;
  if (!given.contains("impacts")) options.config.n_impacts_max = loop::kPaperImpacts;
}

std::vector<Section> sections_of(SimulateOptions& options) {
  return {ball_section(options.world), section_of(options, "Ball, ground and drops"),
          simulation_alone_section(options)};
}

Outcome run_simulate(const SimulateOptions& options, const Run& run) {
  const sim::SimulationConfig config = simulation_config(options, run.common.seed, run.common.n_threads);
  check_files(run, simulation_inputs(options), {options.out, options.write_surface});

  TableWriter table(run, options.out);
  sim::SimulationCounts counts;
  const auto take = [&](std::size_t k, sim::DropResult&& drop) {
    counts.add(k, drop);
    table.add(k, to_table(drop.impacts));
  };
  const sim::Surface surface = surface_of(options, config, run);
  sim::simulate_each(config, surface, take, progress_line(run, "simulate", "drops"));
  if (!options.write_surface.empty())
    write_table(run, options.write_surface, to_table(surface), simulation_inputs(options));
  const sim::SimulationResult result = counts.result();
  table.finish(simulation_inputs(options));

  Outcome outcome;
  outcome.exit_code = result.n_impacts == 0 ? kNotUsable : kDone;
  if (result.n_impacts == 0) outcome.error = "no drop had an impact; see --plate-size, --min-speed and --max-time";
  outcome.result = summary_of(result, config.ball);
  outcome.text = text_of(options, config, result);
  outcome.notes = result.notes;
  return outcome;
}

}  // namespace bouncelab::stages
