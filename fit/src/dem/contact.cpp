// SPDX-License-Identifier: GPL-3.0-or-later
#include "dem/contact.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::fit {
namespace {

/// eps of x'' = -x^(3/2) - damping(x) x' up to the contact's end.
template <class Damping>
double restitution_by_motion(Damping damping, ContactEnd end) {
  constexpr double kStep = 0.005;  // of a contact that lasts 3.2
  constexpr int kMost = 10000;     // one that creeps back never parts
  struct State {
    double x, u;
  };
  const auto acceleration = [&](State s) {
    const double x = std::max(s.x, 0.0);
    return -std::sqrt(x) * x - damping(x) * s.u;
  };
  State s{0.0, 1.0};
  double before = 0.0;
  for (int n = 0; n < kMost; ++n) {  // Runge and Kutta's method of fourth order
    before = s.u;
    const State a = s, b{s.x + 0.5 * kStep * a.u, s.u + 0.5 * kStep * acceleration(a)},
                c{s.x + 0.5 * kStep * b.u, s.u + 0.5 * kStep * acceleration(b)},
                d{s.x + kStep * c.u, s.u + kStep * acceleration(c)};
    s.x += kStep / 6.0 * (a.u + 2.0 * b.u + 2.0 * c.u + d.u);
    s.u += kStep / 6.0 * (acceleration(a) + 2.0 * acceleration(b) + 2.0 * acceleration(c) + acceleration(d));
    if (s.u < 0.0 && (s.x <= 0.0 || (end == ContactEnd::force && acceleration(s) >= 0.0))) break;
  }
  return -std::min(before, s.u);
}

}  // namespace

DemContact dem_contact(const std::optional<Ball>& ball, const std::optional<Material>& plate, double v_mps) {
  Material below = plate.value_or(kGlass);
  Ball taken = ball.value_or(Ball{});
  std::optional<ContactDuration> lasts = contact_duration(taken, below);
  std::string why = ball ? "" : ", for the ball is not named";
  if (!lasts) {
    taken = {};
    below = kGlass;
    lasts = contact_duration(taken, below);
    why = ", for it is not known how long the ball's contacts last: add E= and nu=, or contact-time=, to --ball";
  }
  DemContact contact;
  Ball named = taken;  // a density from mass and size needs no 16 digits
  if (to_text(taken).starts_with("diameter="))
    named.material.density_kgpm3 = std::strtod(formatted("%.5g", named.material.density_kgpm3).c_str(), nullptr);
  contact.ball = to_text(named) + " on " + plate_text(below) + why;
  constexpr double kHertz = 2.943;  // tau = 2.943 (5 m/(4 k_n sqrt R))^(2/5) v^(-1/5)
  const double mass = mass_kg(taken), nu = taken.material.poisson_ratio, tau = lasts->at(v_mps);
  contact.radius_m = taken.radius_m;
  contact.mass_kg = mass;
  contact.density_kgpm3 = taken.material.density_kgpm3;
  contact.poisson_ratio = nu;
  contact.k_n_pa = 1.25 * mass * pow(kHertz / tau, 2.5) / std::sqrt(v_mps * taken.radius_m);
  contact.k_t_pa = 3.0 * (1.0 - nu) / (2.0 - nu) * contact.k_n_pa;
  contact.youngs_modulus_pa = 1.5 * (1.0 - nu * nu) * contact.k_n_pa;
  contact.duration_s = tau * pow(v_mps, 0.2);
  return contact;
}

double dissipative_constant_s(const DemContact& contact, double gamma) {
  return gamma / 1.5 * pow(contact.mass_kg / (contact.k_n_pa * std::sqrt(contact.radius_m)), 0.4);
}

double damping_to_parting(double eps) {
  const double ln = log(eps);
  return -std::sqrt(5.0) * ln / hypot(ln, kPi);
}

double damping_to_last_force(double eps) {
  double least = 0.0, most = 20.0;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (least + most);
    const auto damping = [&](double x) { return middle * std::sqrt(std::sqrt(x)); };
    (restitution_by_motion(damping, ContactEnd::force) > eps ? least : most) = middle;
  }
  return 0.5 * (least + most);
}

double viscoelastic_by_motion(double gamma, double v_mps, ContactEnd end) {
  const double damping = gamma * pow(v_mps, 0.2);
  return restitution_by_motion([&](double x) { return damping * std::sqrt(x); }, end);
}

}  // namespace bouncelab::fit
