// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/simulate_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/loop/records.hpp"
#include "bouncelab/sim/sim.hpp"
#include "files/run_parts.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

sim::ContactModel contact_model(const SimulateOptions& options) {
  if (options.contact == "frictionless") return sim::FrictionlessContact{};
  if (options.contact == "coulomb") return sim::CoulombContact{options.mu};
  if (options.contact == "stronge") return sim::StrongeContact{options.mu};
  return sim::PaperContact{options.beta};
}

template <std::size_t N>
void copy(const std::vector<double>& from, std::array<double, N>& to) {
  for (std::size_t k = 0; k < from.size() && k < N; ++k) to[k] = from[k];
}

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

std::vector<std::int64_t> numbers_of_drops(const sim::SimulationConfig& config) {
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(config.n_drops));
  std::iota(numbers.begin(), numbers.end(), config.first_drop);
  return numbers;
}

std::vector<std::string> items_of(const sim::SimulationConfig& config) {
  std::vector<std::string> items;
  for (const std::int64_t drop : numbers_of_drops(config)) items.push_back(std::to_string(drop));
  return items;
}

/// The drops of the shard, kept in its part.
Outcome run_part(const SimulateOptions& options, const sim::SimulationConfig& config, const Run& run) {
  PartFile part(run, options.out, run_identity(run, simulation_inputs(options), {"write-surface"}), items_of(config));
  const std::vector<std::int64_t> all = numbers_of_drops(config);
  std::vector<std::int64_t> drops;
  for (const std::size_t k : part.pending()) drops.push_back(all[k]);
  if (!drops.empty())
    sim::simulate_each(
        config, surface_of(options, config, progress_line(run, "surface", "asperities")), drops,
        [&](std::size_t k, sim::DropResult&& drop) { part.keep(part.pending()[k], loop::to_record(drop)); },
        progress_line(run, "simulate", "drops"));
  return part.finish(simulation_inputs(options), "drops");
}

/// All drops: simulated, or read from the parts of the run. Also writes the surface where that is wanted.
void simulated_or_read(const SimulateOptions& options, const sim::SimulationConfig& config, const Run& run,
                       const sim::DropSink& sink) {
  std::optional<RunParts> parts;
  if (!run.parts.empty())
    parts.emplace(run, run_identity(run, simulation_inputs(options), {"write-surface"}), items_of(config));
  std::optional<sim::Surface> surface;
  if (!parts || !options.write_surface.empty())
    surface = surface_of(options, config, progress_line(run, "surface", "asperities"));
  if (!parts)
    sim::simulate_each(config, *surface, numbers_of_drops(config), sink, progress_line(run, "simulate", "drops"));
  else
    for (std::size_t k = 0; k < parts->size(); ++k) sink(k, loop::simulated_drop_from_record(parts->record(k)));
  if (!options.write_surface.empty())
    write_table(run, options.write_surface, to_table(*surface), simulation_inputs(options));
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

sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config,
                        const ProgressCallback& progress) {
  if (std::optional<sim::Surface> given = surface_from_file(options, config.ball)) return *std::move(given);
  return sim::make_surface(config.ball, options.n_asperities, sim::radius_law_from_text(options.radius_law),
                           config.seed, progress);
}

sim::SimulationConfig simulation_config(const SimulateOptions& options, const CommonOptions& common) {
  sim::SimulationConfig config = options.config;
  config.seed = common.seed;
  config.n_threads = common.n_threads;
  config.law = restitution_law_from_text(options.restitution_law);
  config.contact = contact_model(options);
  if (options.drag) config.air = Air{};
  if (const std::optional<Ball> ball = ball_of(options.world)) config.ball = *ball;
  if (options.contact_patch) config.patch_plate = plate_of(options.world).value_or(kGlass);
  config.drop_height_min_m = options.height_m.front();
  config.drop_height_max_m = options.height_m.back();
  copy(options.plate_m, config.plate_size_m);
  copy(options.start_m, config.start_position_m);
  copy(options.velocity_mps, config.start_velocity_mps);
  copy(options.spin_radps, config.start_spin_radps);
  validate(config);
  return config;
}

Outcome run_simulate(const SimulateOptions& options, const Run& run, std::vector<sim::Reservoir>* reservoirs) {
  sim::SimulationConfig config = simulation_config(options, run.common);
  if (run.shard) return run_part(options, config, run);
  config.with_state = config.with_state || reservoirs != nullptr;
  check_files(run, simulation_inputs(options), {options.out, options.write_surface});

  TableWriter table(run, options.out);
  sim::SimulationCounts counts;
  std::vector<std::vector<sim::Reservoir>> reservoirs_of_drops;
  const auto take = [&](std::size_t k, sim::DropResult&& drop) {
    counts.add(k, drop);
    if (reservoirs != nullptr) {
      reservoirs_of_drops.resize(std::max(reservoirs_of_drops.size(), k + 1));
      reservoirs_of_drops[k] = sim::reservoirs_after(config.ball, drop.impacts);
    }
    if (!options.config.with_state) drop.impacts.states = {};
    table.add(k, to_table(drop.impacts));
  };
  simulated_or_read(options, config, run, take);
  const sim::SimulationResult result = counts.result();
  if (reservoirs != nullptr)
    for (const std::vector<sim::Reservoir>& drop : reservoirs_of_drops)
      reservoirs->insert(reservoirs->end(), drop.begin(), drop.end());
  table.finish(simulation_inputs(options));

  Outcome outcome;
  outcome.exit_code = result.n_impacts == 0 ? kNotUsable : kDone;
  if (result.n_impacts == 0) outcome.error = "no drop had an impact; see --plate-size, --min-speed and --max-time";
  outcome.json = simulate_json(result, config.ball);
  outcome.text = text_of(options, config, result);
  outcome.warnings = result.warnings;
  return outcome;
}

}  // namespace bouncelab::cli
