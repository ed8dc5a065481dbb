// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/contact.hpp"

#include <cmath>
#include <sstream>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "contact/mobility.hpp"
#include "contact/stronge.hpp"

namespace bouncelab::sim {
namespace {

constexpr Vector3 kNormal{0, 0, 1};

/// What the contact point's velocity was and what its normal part must become.
struct Demand {
  Vector3 v_before;
  double normal_change;  ///< (1 + eps) |v_c.n|
  double eps;
};

Vector3 impulse(const PaperContact& model, const Mobility& k, const Demand& d) {
  const Vector3 tangential{d.v_before.x, d.v_before.y, 0.0};
  return k.impulse_for(d.normal_change * kNormal + (model.beta - 1.0) * tangential);
}

/// An impulse along `direction` that makes the normal change demanded.
Vector3 impulse_along(Vector3 direction, const Mobility& k, const Demand& d) {
  return (d.normal_change / k.velocity_change(direction).z) * direction;
}

Vector3 impulse(const FrictionlessContact&, const Mobility& k, const Demand& d) { return impulse_along(kNormal, k, d); }

Vector3 impulse(const CoulombContact& model, const Mobility& k, const Demand& d) {
  const Vector3 sticking = impulse(PaperContact{0.0}, k, d);
  const double tangential = hypot(sticking.x, sticking.y);
  if (tangential <= model.mu * sticking.z) return sticking;
  const Vector3 edge_of_cone{model.mu * sticking.x / tangential, model.mu * sticking.y / tangential, 1.0};
  return impulse_along(edge_of_cone, k, d);
}

Vector3 impulse(const StrongeContact& model, const Mobility& k, const Demand& d) {
  return stronge_impulse(k, d.v_before, model.mu, d.eps);
}

void check_friction(double mu) {
  if (!(mu >= 0.0 && std::isfinite(mu)))
    throw InvalidArgument("contact: mu = " + std::to_string(mu) + " must be finite and not negative");
}

void check(const PaperContact& model) {
  if (!(model.beta >= -1.0 && model.beta <= 1.0))
    throw InvalidArgument("contact: beta = " + std::to_string(model.beta) + " is outside [-1, 1]");
}
void check(const FrictionlessContact&) {}
void check(const CoulombContact& model) { check_friction(model.mu); }
void check(const StrongeContact& model) { check_friction(model.mu); }

std::string text(const PaperContact& model) {
  std::ostringstream out;
  out << "paper, beta = " << model.beta;
  return out.str();
}
std::string text(const FrictionlessContact&) { return "frictionless"; }
std::string text(const CoulombContact& model) {
  std::ostringstream out;
  out << "coulomb, mu = " << model.mu;
  return out.str();
}
std::string text(const StrongeContact& model) {
  std::ostringstream out;
  out << "stronge, mu = " << model.mu;
  return out.str();
}

}  // namespace

void validate(const ContactModel& model) {
  std::visit([](const auto& m) { check(m); }, model);
}

std::string describe(const ContactModel& model) {
  return std::visit([](const auto& m) { return text(m); }, model);
}

Collision collide(const Ball& ball, const RestitutionLaw& law, const ContactModel& model, Vector3 lever_m,
                  const Motion& before) {
  const Mobility mobility(ball, lever_m);
  const Vector3 v_contact = before.velocity_mps + cross(before.spin_radps, lever_m);
  const double approach_mps = -v_contact.z;
  const double eps = restitution(law, std::abs(approach_mps));
  const Demand demand{v_contact, (1.0 + eps) * approach_mps, eps};
  const Vector3 p = std::visit([&](const auto& m) { return impulse(m, mobility, demand); }, model);
  const Motion after{before.velocity_mps + (1.0 / mobility.m) * p,
                     before.spin_radps + (1.0 / mobility.j) * cross(lever_m, p)};
  return {after, approach_mps, eps, p};
}

}  // namespace bouncelab::sim
