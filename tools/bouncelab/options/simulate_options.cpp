// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "bouncelab/loop/loop_score.hpp"
#include "commands/simulate_command.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {

namespace {

/// Start and end of a drop.
void add_drop_options(CLI::App& app, SimulateOptions& o) {
  sim::SimulationConfig& c = o.config;
  app.add_option("--gravity", c.gravity_mps2, "Gravity [m/s^2]")->check(within(1e-3, 1e3));
  add_list(app, "--height", o.height_m, "LO[,HI]", 1, 2, 1e-6, 1e3,
           "Fall height [m]: one value, or LO,HI to draw between");
  add_list(app, "--start", o.start_m, "X,Y", 2, 2, -1e3, 1e3, "Start position on the plate [m]");
  add_list(app, "--velocity", o.velocity_mps, "X,Y", 2, 2, -1e3, 1e3, "Horizontal start velocity [m/s]");
  add_list(app, "--spin", o.spin_radps, "X,Y,Z", 3, 3, -1e6, 1e6, "Start spin [rad/s]");
  add_list(app, "--plate-size", o.plate_m, "X,Y", 2, 2, 1e-6, 1e6,
           "Size of the plate [m]; a drop ends beyond its edge; default no edge");
  app.add_option("--tilt", c.tilt_rad, "Tilt of the plate, downhill along x [rad]")->check(within(0.0, 1.5707));
  app.add_flag("--drag", o.drag, "Air drag (Schiller-Naumann, 20 degrees C)");
  app.add_option("--min-speed", c.min_speed_mps, "A drop ends before an impact slower than this [m/s]")
      ->check(within(0.0, 1e3));
  app.add_option("--max-time", c.max_time_s, "A drop ends so long after its release [s]")->check(within(1e-6, 1e9));
}

}  // namespace

void add_simulate_options(CLI::App& app, SimulateOptions& o) {
  app.option_defaults()->group("Ball, ground and drops");
  sim::SimulationConfig& c = o.config;
  const auto at_least_1 = within(1, 1'000'000'000);
  app.add_option("--drops", c.n_drops, "Number of drops")->check(at_least_1);
  app.add_option("--impacts", c.n_impacts_max, "A drop ends after so many impacts")->check(at_least_1);
  app.add_option("--asperities", o.n_asperities, "Small spheres on the ball")->check(at_least_1);
  app.add_option("--radius-law", o.radius_law,
                 "Radii of the asperities in units of the ball's: constant:R, uniform:LO,HI, normal:MEAN,SD, "
                 "lognormal:MEDIAN,SIGMA, exponential:MEAN");
  app.add_option("--surface", o.surface_file, "Read the asperities from a table (ux,uy,uz,radius_m) instead")
      ->type_name("FILE");
  app.add_option("--law", o.restitution_law,
                 "eps(v): series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS, table:FILE.csv (v_mps,eps)");
  app.add_option("--contact", o.contact, "Contact model")
      ->check(CLI::IsMember({"paper", "frictionless", "coulomb", "stronge"}));
  app.add_option("--beta", o.beta, "Tangential restitution of the paper's contact model")->check(within(-1.0, 1.0));
  app.add_option("--mu", o.mu, "Coefficient of friction of the coulomb and stronge models")->check(within(0.0, 1e3));
  app.add_flag("--contact-patch", o.contact_patch,
               "Offset of each contact averaged over the Hertzian area of contact on the plate at the impact's speed");
  add_drop_options(app, o);
}

void add_simulation_options(CLI::App& app, SimulateOptions& o) {
  add_ball_options(app, o.world);
  add_simulate_options(app, o);
  app.add_option("--first-drop", o.config.first_drop, "Number of the first drop")
      ->check(within(std::int64_t{0}, std::int64_t{1'000'000'000'000}));
  app.add_option("--preset", o.preset, "paper: 2,320 drops of 95 impacts")->check(CLI::IsMember({"paper"}));
  app.add_flag("--state", o.config.with_state, "Also position, orientation, velocities and energies at each impact");
}

void apply_paper_preset(const CLI::App& app, SimulateOptions& options, Run& run) {
  const auto set = [&](const std::string& name, std::int64_t& value, std::int64_t to) {
    if (app.get_option("--" + name)->count() > 0) return;
    value = to;
    set_parameter(run.parameters, name, std::to_string(to));
  };
  set("drops", options.config.n_drops, loop::kPaperDrops);
  set("impacts", options.config.n_impacts_max, loop::kPaperImpacts);
}

Command add_simulate_command(CLI::App& app) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = app.add_subcommand("simulate", "Drop a rough ball: impact times, velocities, asperities");
  command->footer("Example: bouncelab simulate --drops 10 --asperities 100000 --out impacts.csv");
  command->add_option("--out", options->out, "Impacts, .csv or .jsonl")->type_name("FILE")->required();
  add_simulation_options(*command, *options);
  command->add_option("--write-surface", options->write_surface, "Write the asperities, .csv or .jsonl")
      ->type_name("FILE");
  return {command, [options, command](Run& run) {
            if (options->preset == "paper") apply_paper_preset(*command, *options, run);
            return run_simulate(*options, run);
          }};
}

}  // namespace bouncelab::cli
