// SPDX-License-Identifier: GPL-3.0-or-later
// Balls and plates as results show them.
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"

namespace bouncelab {
namespace {

Object numbers_of(const Material& material) {
  using M = Material;
  const auto if_known = [](double M::*number) {
    return [number](const M& m) { return m.youngs_modulus_pa > 0.0 ? std::optional(m.*number) : std::nullopt; };
  };
  static const Description numbers{
      result("density_kgpm3", &M::density_kgpm3, "Mean density"),
      result<M>("youngs_modulus_pa", if_known(&M::youngs_modulus_pa), "E; `null`: not known"),
      result<M>("poisson_ratio", if_known(&M::poisson_ratio), "Likewise"),
      result("hertzian", &M::hertzian, "Whether Hertz's theory gives the contact time")};
  return object_of(numbers, &material);
}

/// Of a ball of the catalogue that has a size.
std::optional<Ball> ball_of(const BallKind& kind) {
  if (!kind.diameter_m) return std::nullopt;
  return Ball{0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}};
}

}  // namespace

const Description& members_of(const Ball*) {
  using B = Ball;
  static const Description all{result<B>(
                                   "name", [](const B& b) { return to_text(b); }, "Its shortest description"),
                               result("radius_m", &B::radius_m, "Radius"),
                               result<B>("mass_kg", mass_kg, "Mass"),
                               result("inertia_factor", &B::inertia_factor, "J/(m R²)"),
                               result<B>(
                                   "", [](const B& b) { return numbers_of(b.material); }, "Its material"),
                               result("contact_time_s", &B::contact_time_s, "As measured; `null`: by Hertz")};
  return all;
}

const Description& members_of(const Material*) {
  using M = Material;
  static const Description all{result<M>("name", plate_text, "Its shortest description"),
                               result<M>("", numbers_of, "Its numbers")};
  return all;
}

const Description& members_of(const BallKind*) {
  using K = BallKind;
  static const Description all{
      result("name", &K::name, "On the command line"),
      result("what", &K::what, "In words"),
      result<K>(
          "radius_m", [](const K& k) { return ball_of(k) ? std::optional(ball_of(k)->radius_m) : std::nullopt; },
          "`null`: a material, of any size"),
      result<K>(
          "mass_kg", [](const K& k) { return ball_of(k) ? std::optional(mass_kg(*ball_of(k))) : std::nullopt; },
          "Likewise"),
      result("inertia_factor", &K::inertia_factor, "J/(m R²)"),
      result<K>(
          "", [](const K& k) { return numbers_of(k.material); }, "Its material"),
      result("source", &K::source, "Where the numbers are from")};
  return all;
}

const Description& members_of(const PlateKind*) {
  using K = PlateKind;
  static const Description all{result("name", &K::name, "On the command line"), result("what", &K::what, "In words"),
                               result<K>(
                                   "", [](const K& k) { return numbers_of(k.material); }, "Its material"),
                               result("loss_factor", &K::loss_factor, "Of the bending vibrations that make the sound"),
                               result("source", &K::source, "Where the numbers are from")};
  return all;
}

}  // namespace bouncelab
