// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of a simulation are called and what they are, key by key (docs/formats.md is made of these texts).
#include "bouncelab/sim/energy.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

Description members_of(const SimulationResult*) {
  using R = SimulationResult;
  using L = EnergyLedger;
  using K = KineticEnergy;
  static constexpr Member all[]{
      member<&R::n_impacts>("n_impacts", "Impacts"),
      member<&R::n_smooth>("n_impacts_smooth_sphere", "Of the smooth sphere between the asperities"),
      computed(
          "n_drops_ended",
          [](const R& r) {
            const auto ended = [&](DropEnd end) { return r.n_ended[static_cast<std::size_t>(end)]; };
            return Object{{"impacts", ended(DropEnd::impacts_reached)},
                          {"speed", ended(DropEnd::speed_reached)},
                          {"time", ended(DropEnd::time_reached)},
                          {"left_plate", ended(DropEnd::left_plate)}};
          },
          "Drops by what ended them: `impacts`, `speed`, `time`, `left_plate`"),
      member<&R::energy, &L::released_j>("energy_released_j", "Kinetic and potential, at release"),
      member<&R::energy, &L::remaining_j>("energy_remaining_j", "After the last impact"),
      member<&R::energy, &L::dissipated_j>("energy_dissipated_j", "In contacts"),
      member<&R::energy, &L::created_j>("energy_created_j", "In contacts, by the law of restitution"),
      member<&R::energy, &L::drag_j>("energy_drag_j", "Lost to the air"),
      member<&R::energy, &L::gained_impact_j, &K::vertical_j>("energy_gained_vertical_j",
                                                              "After less before, of all impacts"),
      member<&R::energy, &L::gained_impact_j, &K::horizontal_j>("energy_gained_horizontal_j", "Likewise"),
      member<&R::energy, &L::gained_impact_j, &K::rotational_j>("energy_gained_rotational_j", "Likewise"),
      computed(
          "energy_closure", [](const R& r) { return r.energy.closure(); },
          "(released + created - dissipated - drag - remaining) / released"),
      computed(
          "n_impacts_creating_energy", [](const R& r) { return static_cast<std::int64_t>(r.energy.n_creating); },
          "Such impacts")};
  return all;
}

Description members_of(const EnergyShares*) {
  using S = EnergyShares;
  static constexpr Member all[]{member<&S::impact>("impact", "Number of the impact within its drop"),
                                member<&S::n>("n", "Drops that had it"),
                                member<&S::vertical>("vertical", "Mean share"),
                                member<&S::horizontal>("horizontal", "Mean share"),
                                member<&S::rotational>("rotational", "Mean share"),
                                member<&S::rotational_lo>("rotational_lo", "16 % quantile over the drops"),
                                member<&S::rotational_hi>("rotational_hi", "84 % quantile")};
  return all;
}

Description members_of(const SectionCircle*) {
  static constexpr Member all[]{member<&SectionCircle::angle_rad>("angle_rad", "Of its centre along the ball's circle"),
                                member<&SectionCircle::radius_m>("radius_m", "Of the circle in the plane")};
  return all;
}

Description members_of(const BallSection*) {
  using B = BallSection;
  static constexpr Member all[]{
      member<&B::ball_radius_m>("radius_m", "Of the ball"),
      member<&B::n_asperities>("n_asperities", "Of the whole ball"),
      member<&B::mean_asperity_radius_m>("mean_asperity_radius_m", "Likewise"),
      computed(
          "section",
          [](const B& b) {
            Object section{{"half_angle_rad", b.half_angle_rad}};
            append(section, as_lists(b.circles));
            return section;
          },
          "`half_angle_rad`, and of the asperities that a plane through the centre cuts on that piece "
          "`angle_rad`, `radius_m` (of the circle in the plane)")};
  return all;
}

}  // namespace bouncelab::sim
