// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of a simulation are called and what they are, key by key (docs/formats.md is made of these texts).
#include "bouncelab/sim/energy.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

const Description& members_of(const SimulationResult*) {
  using R = SimulationResult;
  const auto energy = [](double EnergyLedger::*which) { return [which](const R& r) { return r.energy.*which; }; };
  const auto gained = [](double KineticEnergy::*which) {
    return [which](const R& r) { return r.energy.gained_impact_j.*which; };
  };
  static const Description all{
      result("n_impacts", &R::n_impacts, "Impacts"),
      result("n_impacts_smooth_sphere", &R::n_smooth, "Of the smooth sphere between the asperities"),
      result<R>(
          "n_drops_ended",
          [](const R& r) {
            const auto ended = [&](DropEnd end) { return r.n_ended[static_cast<std::size_t>(end)]; };
            return Object{{"impacts", ended(DropEnd::impacts_reached)},
                          {"speed", ended(DropEnd::speed_reached)},
                          {"time", ended(DropEnd::time_reached)},
                          {"left_plate", ended(DropEnd::left_plate)}};
          },
          "Drops by what ended them: `impacts`, `speed`, `time`, `left_plate`"),
      result<R>("energy_released_j", energy(&EnergyLedger::released_j), "Kinetic and potential, at release"),
      result<R>("energy_remaining_j", energy(&EnergyLedger::remaining_j), "After the last impact"),
      result<R>("energy_dissipated_j", energy(&EnergyLedger::dissipated_j), "In contacts"),
      result<R>("energy_created_j", energy(&EnergyLedger::created_j), "In contacts, by the law of restitution"),
      result<R>("energy_drag_j", energy(&EnergyLedger::drag_j), "Lost to the air"),
      result<R>("energy_gained_vertical_j", gained(&KineticEnergy::vertical_j), "After less before, of all impacts"),
      result<R>("energy_gained_horizontal_j", gained(&KineticEnergy::horizontal_j), "Likewise"),
      result<R>("energy_gained_rotational_j", gained(&KineticEnergy::rotational_j), "Likewise"),
      result<R>(
          "energy_closure", [](const R& r) { return r.energy.closure(); },
          "(released + created - dissipated - drag - remaining) / released"),
      result<R>(
          "n_impacts_creating_energy", [](const R& r) { return static_cast<std::int64_t>(r.energy.n_creating); },
          "Such impacts")};
  return all;
}

const Description& members_of(const EnergyShares*) {
  using S = EnergyShares;
  static const Description all{result("impact", &S::impact, "Number of the impact within its drop"),
                               result("n", &S::n, "Drops that had it"),
                               result("vertical", &S::vertical, "Mean share"),
                               result("horizontal", &S::horizontal, "Mean share"),
                               result("rotational", &S::rotational, "Mean share"),
                               result("rotational_lo", &S::rotational_lo, "16 % quantile over the drops"),
                               result("rotational_hi", &S::rotational_hi, "84 % quantile")};
  return all;
}

const Description& members_of(const SectionCircle*) {
  static const Description all{result("angle_rad", &SectionCircle::angle_rad, "Of its centre along the ball's circle"),
                               result("radius_m", &SectionCircle::radius_m, "Of the circle in the plane")};
  return all;
}

const Description& members_of(const BallSection*) {
  using B = BallSection;
  static const Description all{
      result("radius_m", &B::ball_radius_m, "Of the ball"),
      result("n_asperities", &B::n_asperities, "Of the whole ball"),
      result("mean_asperity_radius_m", &B::mean_asperity_radius_m, "Likewise"),
      result<B>(
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
