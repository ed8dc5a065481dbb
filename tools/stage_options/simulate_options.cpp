// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/simulate_options.hpp"

#include <algorithm>
#include <array>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/sim/contact.hpp"

namespace bouncelab::options {
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

}  // namespace

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
      member("drag", &O::drag, "Air drag (standard curve of a sphere, 20 degrees C)"),
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

sim::SimulationConfig simulation_config(const SimulateOptions& options, std::uint64_t seed, int n_threads) {
  sim::SimulationConfig config = options.config;
  config.seed = seed;
  config.n_threads = n_threads;
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

}  // namespace bouncelab::options
