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

Description members_of(const SimulateOptions*) {
  using O = SimulateOptions;
  using C = sim::SimulationConfig;
  static constexpr Member options[]{
      member<&O::config, &C::n_drops>("drops", "Number of drops").within(1, 1e9),
      member<&O::config, &C::n_impacts_max>("impacts", "A drop ends after so many impacts").within(1, 1e9),
      member<&O::n_asperities>("asperities", "Small spheres on the ball").within(1, 1e9),
      member<&O::radius_law>(
          "radius_law",
          "Radii of the asperities in units of the ball's: constant:R, uniform:LO,HI, normal:MEAN,SD, "
          "lognormal:MEDIAN,SIGMA, exponential:MEAN"),
      member<&O::surface_file>("surface", "Read the asperities from a table (ux,uy,uz,radius_m) instead")
          .looks_like("FILE"),
      member<&O::restitution_law>(
          "law", "eps(v): series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS, table:FILE.csv (v_mps,eps)"),
      member<&O::contact>("contact", "Contact model").one_of("paper,frictionless,coulomb,stronge"),
      member<&O::beta>("beta", "Tangential restitution of the paper's contact model").within(-1.0, 1.0),
      member<&O::mu>("mu", "Coefficient of friction of the coulomb and stronge models").within(0.0, 1e3),
      member<&O::contact_patch>(
          "contact_patch",
          "Offset of each contact averaged over the Hertzian area of contact on the plate at the impact's speed"),
      member<&O::config, &C::gravity_mps2>("gravity", "Gravity [m/s^2]").within(1e-3, 1e3),
      member<&O::height_m>("height", "Fall height [m]: one value, or LO,HI to draw between")
          .with_commas("LO[,HI]", 1, 2)
          .within(1e-6, 1e3),
      member<&O::start_m>("start", "Start position on the plate [m]").with_commas("X,Y", 2, 2).within(-1e3, 1e3),
      member<&O::velocity_mps>("velocity", "Horizontal start velocity [m/s]")
          .with_commas("X,Y", 2, 2)
          .within(-1e3, 1e3),
      member<&O::spin_radps>("spin", "Start spin [rad/s]").with_commas("X,Y,Z", 3, 3).within(-1e6, 1e6),
      member<&O::plate_m>("plate_size", "Size of the plate [m]; a drop ends beyond its edge; default no edge")
          .with_commas("X,Y", 2, 2)
          .within(1e-6, 1e6),
      member<&O::config, &C::tilt_rad>("tilt", "Tilt of the plate, downhill along x [rad]").within(0.0, 1.5707),
      member<&O::drag>("drag", "Air drag (standard curve of a sphere, 20 degrees C)"),
      member<&O::config, &C::min_speed_mps>("min_speed", "A drop ends before an impact slower than this [m/s]")
          .within(0.0, 1e3),
      member<&O::config, &C::max_time_s>("max_time", "A drop ends so long after its release [s]").within(1e-6, 1e9)};
  return options;
}

Section simulation_alone_section(SimulateOptions& options) {
  using O = SimulateOptions;
  using C = sim::SimulationConfig;
  static constexpr Member alone[]{
      member<&O::config, &C::first_drop>("first_drop", "Number of the first drop").within(0, 1e12),
      member<&O::preset>("preset", "paper: 2,320 drops of 95 impacts").one_of("paper"),
      member<&O::config, &C::with_state>("state",
                                         "Also position, orientation, velocities and energies at each impact")};
  return {"Ball, ground and drops", alone, &options};
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
