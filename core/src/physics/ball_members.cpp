// SPDX-License-Identifier: GPL-3.0-or-later
// Balls and plates as results show them.
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"

namespace bouncelab {
namespace {

std::optional<double> if_known(const Material& m, double number) {
  return m.youngs_modulus_pa > 0.0 ? std::optional(number) : std::nullopt;
}

Object numbers_of(const Material& material) {
  using M = Material;
  static constexpr Member numbers[]{
      member<&M::density_kgpm3>("density_kgpm3", "Mean density"),
      computed(
          "youngs_modulus_pa", [](const M& m) { return if_known(m, m.youngs_modulus_pa); }, "E; `null`: not known"),
      computed(
          "poisson_ratio", [](const M& m) { return if_known(m, m.poisson_ratio); }, "Likewise"),
      member<&M::hertzian>("hertzian", "Whether Hertz's theory gives the contact time")};
  return object_of(numbers, &material);
}

/// Of a ball of the catalogue that has a size.
std::optional<Ball> ball_of(const BallKind& kind) {
  if (!kind.diameter_m) return std::nullopt;
  return Ball{0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}};
}

}  // namespace

Description members_of(const Ball*) {
  using B = Ball;
  static constexpr Member all[]{computed(
                                    "name", [](const B& b) { return to_text(b); }, "Its shortest description"),
                                member<&B::radius_m>("radius_m", "Radius"),
                                member<mass_kg>("mass_kg", "Mass"),
                                member<&B::inertia_factor>("inertia_factor", "J/(m R²)"),
                                computed(
                                    "", [](const B& b) { return numbers_of(b.material); }, "Its material"),
                                member<&B::contact_time_s>("contact_time_s", "As measured; `null`: by Hertz")};
  return all;
}

Description members_of(const Material*) {
  static constexpr Member all[]{member<plate_text>("name", "Its shortest description"),
                                member<numbers_of>("", "Its numbers")};
  return all;
}

Description members_of(const BallKind*) {
  using K = BallKind;
  static constexpr Member all[]{
      member<&K::name>("name", "On the command line"),
      member<&K::what>("what", "In words"),
      computed(
          "radius_m", [](const K& k) { return ball_of(k) ? std::optional(ball_of(k)->radius_m) : std::nullopt; },
          "`null`: a material, of any size"),
      computed(
          "mass_kg", [](const K& k) { return ball_of(k) ? std::optional(mass_kg(*ball_of(k))) : std::nullopt; },
          "Likewise"),
      member<&K::inertia_factor>("inertia_factor", "J/(m R²)"),
      computed(
          "", [](const K& k) { return numbers_of(k.material); }, "Its material"),
      member<&K::source>("source", "Where the numbers are from")};
  return all;
}

Description members_of(const PlateKind*) {
  using K = PlateKind;
  static constexpr Member all[]{member<&K::name>("name", "On the command line"), member<&K::what>("what", "In words"),
                                computed(
                                    "", [](const K& k) { return numbers_of(k.material); }, "Its material"),
                                member<&K::loss_factor>("loss_factor", "Of the bending vibrations that make the sound"),
                                member<&K::source>("source", "Where the numbers are from")};
  return all;
}

}  // namespace bouncelab
