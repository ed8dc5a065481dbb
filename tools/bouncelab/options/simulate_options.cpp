// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "bouncelab/loop/loop_score.hpp"
#include "commands/simulate_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

const Description& members_of(const SimulateOptions*) {
  using O = SimulateOptions;
  static const Description options{
      member<O>(
          "drops", [](auto& o) -> auto& { return o.config.n_drops; }, "Number of drops")
          .within(1, 1e9),
      member<O>(
          "impacts", [](auto& o) -> auto& { return o.config.n_impacts_max; }, "A drop ends after so many impacts")
          .within(1, 1e9),
      member("asperities", &O::n_asperities, "Small spheres on the ball").within(1, 1e9),
      member("radius_law", &O::radius_law,
             "Radii of the asperities in units of the ball's: constant:R, uniform:LO,HI, normal:MEAN,SD, "
             "lognormal:MEDIAN,SIGMA, exponential:MEAN"),
      member("surface", &O::surface_file, "Read the asperities from a table (ux,uy,uz,radius_m) instead")
          .looks_like("FILE"),
      member("law", &O::restitution_law,
             "eps(v): series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS, table:FILE.csv (v_mps,eps)"),
      member("contact", &O::contact, "Contact model").one_of({"paper", "frictionless", "coulomb", "stronge"}),
      member("beta", &O::beta, "Tangential restitution of the paper's contact model").within(-1.0, 1.0),
      member("mu", &O::mu, "Coefficient of friction of the coulomb and stronge models").within(0.0, 1e3),
      member("contact_patch", &O::contact_patch,
             "Offset of each contact averaged over the Hertzian area of contact on the plate at the impact's speed"),
      member<O>(
          "gravity", [](auto& o) -> auto& { return o.config.gravity_mps2; }, "Gravity [m/s^2]")
          .within(1e-3, 1e3),
      member("height", &O::height_m, "Fall height [m]: one value, or LO,HI to draw between")
          .with_commas("LO[,HI]", 1, 2)
          .within(1e-6, 1e3),
      member("start", &O::start_m, "Start position on the plate [m]").with_commas("X,Y", 2, 2).within(-1e3, 1e3),
      member("velocity", &O::velocity_mps, "Horizontal start velocity [m/s]")
          .with_commas("X,Y", 2, 2)
          .within(-1e3, 1e3),
      member("spin", &O::spin_radps, "Start spin [rad/s]").with_commas("X,Y,Z", 3, 3).within(-1e6, 1e6),
      member("plate_size", &O::plate_m, "Size of the plate [m]; a drop ends beyond its edge; default no edge")
          .with_commas("X,Y", 2, 2)
          .within(1e-6, 1e6),
      member<O>(
          "tilt", [](auto& o) -> auto& { return o.config.tilt_rad; }, "Tilt of the plate, downhill along x [rad]")
          .within(0.0, 1.5707),
      member("drag", &O::drag, "Air drag (Schiller-Naumann, 20 degrees C)"),
      member<O>(
          "min_speed", [](auto& o) -> auto& { return o.config.min_speed_mps; },
          "A drop ends before an impact slower than this [m/s]")
          .within(0.0, 1e3),
      member<O>(
          "max_time", [](auto& o) -> auto& { return o.config.max_time_s; }, "A drop ends so long after its release [s]")
          .within(1e-6, 1e9)};
  return options;
}

Section simulation_alone_section(SimulateOptions& options) {
  using O = SimulateOptions;
  static const Description alone{
      member<O>(
          "first_drop", [](auto& o) -> auto& { return o.config.first_drop; }, "Number of the first drop")
          .within(0, 1e12),
      member("preset", &O::preset, "paper: 2,320 drops of 95 impacts").one_of({"paper"}),
      member<O>(
          "state", [](auto& o) -> auto& { return o.config.with_state; },
          "Also position, orientation, velocities and energies at each impact")};
  return {"Ball, ground and drops", &alone, &options};
}

void apply_paper_preset(SimulateOptions& options, Run& run) {
  const auto set = [&](const std::string& name, std::int64_t& value, std::int64_t to) {
    if (run.given.contains(name)) return;
    value = to;
    set_parameter(run.parameters, name, std::to_string(to));
  };
  set("drops", options.config.n_drops, loop::kPaperDrops);
  set("impacts", options.config.n_impacts_max, loop::kPaperImpacts);
}

Command simulate_command() {
  using O = SimulateOptions;
  static const Description files{
      member("out", &O::out, "Impacts, .csv or .jsonl").looks_like("FILE").required(),
      member("write_surface", &O::write_surface, "Write the asperities, .csv or .jsonl").looks_like("FILE")};
  static const Description ball = ball_options("");
  auto options = std::make_shared<O>();
  return {"simulate",
          "Drop a rough ball: impact times, velocities, asperities",
          "Example: bouncelab simulate --drops 10 --asperities 100000 --out impacts.csv",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Ball, ground and drops", &members_of(options.get()), options.get()},
           simulation_alone_section(*options)},
          [options](Run& run) {
            if (options->preset == "paper") apply_paper_preset(*options, run);
            return run_simulate(*options, run);
          }};
}

}  // namespace bouncelab::cli
