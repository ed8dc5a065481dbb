// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/simulate_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/sim.hpp"
#include "files/table_file.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

sim::ContactModel contact_model(const SimulateOptions& options) {
  if (options.contact == "frictionless") return sim::FrictionlessContact{};
  if (options.contact == "coulomb") return sim::CoulombContact{options.mu};
  return sim::PaperContact{options.beta};
}

template <std::size_t N>
void copy(const std::vector<double>& from, std::array<double, N>& to) {
  for (std::size_t k = 0; k < from.size() && k < N; ++k) to[k] = from[k];
}

Json summary_of(const sim::SimulationResult& result) {
  const sim::EnergyLedger& energy = result.energy;
  const auto ended = [&](sim::DropEnd end) { return result.n_ended[static_cast<std::size_t>(end)]; };
  return {{"n_impacts", result.impacts.rows.size()},
          {"n_impacts_smooth_sphere", result.n_smooth},
          {"n_drops_ended",
           {{"impacts", ended(sim::DropEnd::impacts_reached)},
            {"speed", ended(sim::DropEnd::speed_reached)},
            {"time", ended(sim::DropEnd::time_reached)},
            {"left_plate", ended(sim::DropEnd::left_plate)}}},
          {"energy_released_j", energy.released_j},
          {"energy_remaining_j", energy.remaining_j},
          {"energy_dissipated_j", energy.dissipated_j},
          {"energy_created_j", energy.created_j},
          {"energy_drag_j", energy.drag_j},
          {"energy_gained_vertical_j", energy.gained_impact_j.vertical_j},
          {"energy_gained_horizontal_j", energy.gained_impact_j.horizontal_j},
          {"energy_gained_rotational_j", energy.gained_impact_j.rotational_j},
          {"energy_closure", energy.closure()},
          {"n_impacts_creating_energy", energy.n_creating}};
}

std::string text_of(const SimulateOptions& options, const sim::SimulationConfig& config,
                    const sim::SimulationResult& result) {
  const sim::EnergyLedger& energy = result.energy;
  return fmt::format(
      "{} impacts of {} drops in {} ({:.1f}% of them on the smooth sphere)\n"
      "law: {}; contact: {}\n"
      "energy: released {:.4g} J, dissipated {:.2f}%, created {:.3g}%, still in the balls {:.2f}%\n",
      result.impacts.rows.size(), config.n_drops, options.out,
      100.0 * static_cast<double>(result.n_smooth) /
          static_cast<double>(std::max<std::size_t>(1, result.impacts.rows.size())),
      describe(config.law), describe(config.contact), energy.released_j,
      100.0 * energy.dissipated_j / energy.released_j, 100.0 * energy.created_j / energy.released_j,
      100.0 * energy.remaining_j / energy.released_j);
}

std::vector<std::filesystem::path> inputs_of(const SimulateOptions& options) {
  if (options.surface_file.empty()) return {};
  return {options.surface_file};
}

}  // namespace

void apply_paper_preset(const CLI::App& app, SimulateOptions& options, Run& run) {
  const auto set = [&](const char* name, const char* key, std::int64_t& value, std::int64_t to) {
    if (app.get_option(name)->count() > 0) return;
    value = to;
    run.parameters[key] = std::to_string(to);
  };
  set("--drops", "drops", options.config.n_drops, 2320);
  set("--impacts", "impacts", options.config.n_impacts_max, 95);
}

sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config,
                        const ProgressCallback& progress) {
  if (!options.surface_file.empty())
    return sim::surface_from_table(read_table(options.surface_file, sim::surface_columns()), options.surface_file,
                                   config.ball);
  return sim::make_surface(config.ball, options.n_asperities, sim::radius_law_from_text(options.radius_law),
                           config.seed, progress);
}

void add_simulate_options(CLI::App& app, SimulateOptions& o) {
  sim::SimulationConfig& c = o.config;
  const auto at_least_1 = CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000});
  const auto positive = CLI::PositiveNumber;
  app.add_option("--drops", c.n_drops, "Number of drops")->check(at_least_1);
  app.add_option("--impacts", c.n_impacts_max, "A drop ends after so many impacts")->check(at_least_1);
  app.add_option("--asperities", o.n_asperities, "Small spheres on the ball")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}));
  app.add_option("--radius-law", o.radius_law,
                 "Radii of the asperities in units of the ball's: constant:R, uniform:LO,HI, normal:MEAN,SD, "
                 "lognormal:MEDIAN,SIGMA, exponential:MEAN");
  app.add_option("--surface", o.surface_file, "Read the asperities from a table (ux,uy,uz,radius_m) instead");
  app.add_option("--law", o.restitution_law,
                 "eps(v): series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS, table:FILE.csv (v_mps,eps)");
  app.add_option("--contact", o.contact, "Contact model")->check(CLI::IsMember({"paper", "frictionless", "coulomb"}));
  app.add_option("--beta", o.beta, "Tangential restitution of the paper's contact model")->check(CLI::Range(-1.0, 1.0));
  app.add_option("--mu", o.mu, "Coefficient of friction of the Coulomb model")->check(CLI::NonNegativeNumber);
  app.add_option("--radius", c.ball.radius_m, "Radius of the ball [m]")->check(positive);
  app.add_option("--density", c.ball.material.density_kgpm3, "Density of the ball [kg/m^3]")->check(positive);
  app.add_option("--gravity", c.gravity_mps2, "[m/s^2]")->check(positive);
  app.add_option("--height", o.height_m, "Fall height [m]: one value, or LO,HI to draw between")
      ->delimiter(',')
      ->expected(1, 2)
      ->check(positive);
  app.add_option("--start", o.start_m, "Start position X,Y on the plate [m]")->delimiter(',')->expected(2);
  app.add_option("--velocity", o.velocity_mps, "Horizontal start velocity X,Y [m/s]")->delimiter(',')->expected(2);
  app.add_option("--spin", o.spin_radps, "Start spin X,Y,Z [rad/s]")->delimiter(',')->expected(3);
  app.add_option("--plate", o.plate_m, "Size X,Y of the plate [m]; a drop ends beyond its edge (default: no edge)")
      ->delimiter(',')
      ->expected(2)
      ->check(positive);
  app.add_option("--tilt", c.tilt_rad, "Tilt of the plate, downhill along x [rad]")->check(CLI::Range(0.0, 1.5707));
  app.add_flag("--drag", o.drag, "Air drag (Schiller-Naumann, 20 degrees C)");
  app.add_option("--min-speed", c.min_speed_mps, "A drop ends before an impact slower than this [m/s]")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--max-time", c.max_time_s, "A drop ends so long after its release [s]")->check(positive);
}

sim::SimulationConfig simulation_config(const SimulateOptions& options, const CommonOptions& common) {
  sim::SimulationConfig config = options.config;
  config.seed = common.seed;
  config.n_threads = common.n_threads;
  config.law = restitution_law_from_text(options.restitution_law);
  config.contact = contact_model(options);
  if (options.drag) config.air = Air{};
  config.drop_height_min_m = options.height_m.front();
  config.drop_height_max_m = options.height_m.back();
  copy(options.plate_m, config.plate_size_m);
  copy(options.start_m, config.start_position_m);
  copy(options.velocity_mps, config.start_velocity_mps);
  copy(options.spin_radps, config.start_spin_radps);
  validate(config);
  return config;
}

Outcome run_simulate(const SimulateOptions& options, Run& run) {
  const sim::SimulationConfig config = simulation_config(options, run.common);
  check_may_write(run, options.out);
  if (!options.write_surface.empty()) check_may_write(run, options.write_surface);

  const sim::Surface surface = surface_of(options, config, progress_line(run, "surface", "asperities"));
  const sim::SimulationResult result = sim::simulate(config, surface, progress_line(run, "simulate", "drops"));

  if (!options.write_surface.empty()) write_table(run, options.write_surface, to_table(surface), inputs_of(options));
  write_table(run, options.out, to_table(result.impacts), inputs_of(options));
  Outcome outcome;
  outcome.exit_code = result.impacts.rows.empty() ? kNotUsable : kDone;
  if (result.impacts.rows.empty()) outcome.trouble = "no drop had an impact; see --plate, --min-speed and --max-time";
  outcome.summary = summary_of(result);
  outcome.text = text_of(options, config, result);
  outcome.warnings = result.warnings;
  return outcome;
}

Command add_simulate_command(CLI::App& app) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = app.add_subcommand("simulate", "Drop a rough ball: impact times, velocities, asperities");
  command->footer("Example: bouncelab simulate --drops 10 --asperities 100000 --out impacts.csv");
  command->add_option("--out", options->out, "Impacts: FILE.csv or FILE.h5")->required();
  add_simulate_options(*command, *options);
  command->add_option("--first-drop", options->config.first_drop, "Number of the first drop")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1'000'000'000'000}));
  command->add_option("--preset", options->preset, "paper: 2,320 drops of 95 impacts")->check(CLI::IsMember({"paper"}));
  command->add_option("--write-surface", options->write_surface, "Write the asperities: FILE.csv or FILE.h5");
  command->add_flag("--state", options->config.with_state,
                    "Also position, orientation, velocities and energies at each impact");
  return {command, [options, command](Run& run) {
            if (options->preset == "paper") apply_paper_preset(*command, *options, run);
            return run_simulate(*options, run);
          }};
}

}  // namespace bouncelab::cli
