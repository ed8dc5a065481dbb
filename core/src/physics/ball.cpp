// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/ball.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace bouncelab {

double mass_kg(const Ball& ball) {
  return 4.0 / 3.0 * std::numbers::pi * ball.radius_m * ball.radius_m * ball.radius_m * ball.material.density_kgpm3;
}

double moment_of_inertia_kgm2(const Ball& ball) {
  return ball.inertia_factor * mass_kg(ball) * ball.radius_m * ball.radius_m;
}

double shell_inertia_factor(double mean_density_kgpm3, double shell_density_kgpm3) {
  const double filled = mean_density_kgpm3 / shell_density_kgpm3;  // share of the volume
  return 0.4 * (1.0 - pow(1.0 - filled, 5.0 / 3.0)) / filled;
}

double drag_rate_per_s(const Ball& ball, const Air& air, double v_mps) {
  const double reynolds = 2.0 * ball.radius_m * v_mps * air.density_kgpm3 / air.viscosity_pas;
  const double stokes_per_s = 4.5 * air.viscosity_pas / (ball.material.density_kgpm3 * square(ball.radius_m));
  // C_d Re / 24
  return stokes_per_s * (1.0 + 0.15 * pow(reynolds, 0.681) + 0.407 / 24.0 * square(reynolds) / (reynolds + 8710.0));
}

double drag_per_m(const Ball& ball, const Air& air, double v_mps) { return drag_rate_per_s(ball, air, v_mps) / v_mps; }

Flight flight_with_drag(double duration_s, double gravity_mps2, double kappa_per_m) {
  const double free_mps = 0.5 * gravity_mps2 * duration_s;
  if (!(kappa_per_m > 0.0)) return {free_mps, free_mps};
  const double limit_mps = std::sqrt(gravity_mps2 / kappa_per_m);
  const double wanted = 2.0 * free_mps / limit_mps;
  // Newton's steps upwards from below: atan x + asinh x, which is concave, is at most 2 x
  double x = 0.5 * wanted;
  for (int i = 0; i < 50; ++i) {
    const double step = (wanted - std::atan(x) - std::asinh(x)) / (1.0 / (1.0 + x * x) + 1.0 / std::sqrt(1.0 + x * x));
    x += step;
    if (std::abs(step) < 1e-15 * x) break;
  }
  return {limit_mps * x, limit_mps * x / std::sqrt(1.0 + x * x)};
}

double fall_with_drag_mps(double height_m, double gravity_mps2, double kappa_per_m) {
  if (!(kappa_per_m > 0.0)) return std::sqrt(2.0 * gravity_mps2 * height_m);
  return std::sqrt(-gravity_mps2 / kappa_per_m * std::expm1(-2.0 * kappa_per_m * height_m));
}

double fall_height_m(double landing_mps, double gravity_mps2, double kappa_per_m) {
  const double height_m = landing_mps * landing_mps / (2.0 * gravity_mps2);
  if (!(kappa_per_m > 0.0)) return height_m;
  const double of_limit = 2.0 * kappa_per_m * height_m;  // the square of the speed over its limit
  return of_limit < 1.0 ? -std::log1p(-of_limit) / (2.0 * kappa_per_m) : HUGE_VAL;
}

double rise_height_m(double launch_mps, double gravity_mps2, double kappa_per_m) {
  const double height_m = launch_mps * launch_mps / (2.0 * gravity_mps2);
  return kappa_per_m > 0.0 ? std::log1p(2.0 * kappa_per_m * height_m) / (2.0 * kappa_per_m) : height_m;
}

std::optional<ContactDuration> contact_duration(const Ball& ball, const std::optional<Material>& plate) {
  if (ball.contact_time_s) return ContactDuration{*ball.contact_time_s, 0.0, 0.1};
  if (ball.material.hertzian) {
    if (!plate || !plate->hertzian) return std::nullopt;
    return ContactDuration{hertz_contact_time_s(ball, *plate, 1.0)};
  }
  return ball.usual_contact;
}

namespace {

/// 15 m / (16 E* sqrt R): the greatest compression is (this v^2)^(2/5) [m^(5/2) s^2/m^2].
double hertz_scale(const Ball& ball, const Material& plate) {
  const auto compliance = [](const Material& m) {
    return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus_pa;
  };
  const double effective_modulus_pa = 1.0 / (compliance(ball.material) + compliance(plate));
  return 15.0 * mass_kg(ball) / (16.0 * effective_modulus_pa * std::sqrt(ball.radius_m));
}

}  // namespace

double hertz_contact_time_s(const Ball& ball, const Material& plate, double v_mps) {
  return 2.943 * pow(hertz_scale(ball, plate), 0.4) * pow(v_mps, -0.2);
}

double hertz_patch_radius_m(const Ball& ball, const Material& plate, double v_mps) {
  if (v_mps == 0.0) return 0.0;
  return std::sqrt(ball.radius_m * pow(hertz_scale(ball, plate) * v_mps * v_mps, 0.4));
}

namespace {

/// Half the contact time in units of (largest indentation)/v: integral of dx / sqrt(1 - x^(5/2)) from 0 to 1,
/// = (2/5) B(2/5, 1/2).
constexpr double kHalfDuration = 1.4716375921623523;

double acceleration(double x) { return x > 0.0 ? -1.25 * x * std::sqrt(x) : 0.0; }

/// Indentation on a grid over the first half of the contact, by Runge-Kutta, read by cubic Hermite interpolation.
class Indentation {
 public:
  Indentation() {
    double x = 0.0, v = 1.0;
    for (std::size_t k = 0; k <= kSteps; ++k) {
      x_[k] = x;
      v_[k] = v;
      const double a1 = acceleration(x), a2 = acceleration(x + 0.5 * step_ * v),
                   a3 = acceleration(x + 0.5 * step_ * v + 0.25 * step_ * step_ * a1),
                   a4 = acceleration(x + step_ * v + 0.5 * step_ * step_ * a2);
      x += step_ * v + step_ * step_ / 6.0 * (a1 + a2 + a3);
      v += step_ / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
  }
  /// @param t  in [0, kHalfDuration]
  double operator()(double t) const {
    const double position = t / step_;
    const auto k = std::min(static_cast<std::size_t>(position), kSteps - 1);
    const double u = position - static_cast<double>(k), w = 1.0 - u;
    return w * w * ((1.0 + 2.0 * u) * x_[k] + u * step_ * v_[k]) +
           u * u * ((1.0 + 2.0 * w) * x_[k + 1] - w * step_ * v_[k + 1]);
  }

 private:
  static constexpr std::size_t kSteps = 1024;
  const double step_ = kHalfDuration / static_cast<double>(kSteps);
  std::array<double, kSteps + 1> x_{}, v_{};
};

}  // namespace

double hertz_force(double s) {
  if (s <= 0.0 || s >= 1.0) return 0.0;
  static const Indentation indentation;
  const double x = std::max(0.0, indentation(2.0 * kHalfDuration * std::min(s, 1.0 - s)));
  // Newton: the impulse is 2 (there and back at speed 1) and the force 5/4 x^(3/2) per unit mass
  return 1.25 * x * std::sqrt(x) * kHalfDuration;
}

namespace {

/// n - 1 nodes.
PointImpulses impulses_of_order(int n) {
  PointImpulses points;
  double total = 0.0;
  for (int k = 1; k < n; ++k) {
    const double theta = std::numbers::pi * k / n;
    points.nodes.push_back(0.5 * (1.0 - cos(theta)));
    points.weights.push_back(sin(theta) * hertz_force(points.nodes.back()));
    total += points.weights.back();
  }
  for (double& weight : points.weights) weight /= total;
  return points;
}

constexpr int kFewest = 12;  // 12 + 0.95 d of a contact of d samples

}  // namespace

PointImpulses hertz_impulses(double duration_samples) {
  constexpr int kMostKept = 48;  // a recording has thousands of contacts, of few orders: those of up to 37 samples
  static const std::array<PointImpulses, kMostKept - kFewest + 1> kept = [] {
    std::array<PointImpulses, kMostKept - kFewest + 1> all;
    for (int n = kFewest; n <= kMostKept; ++n) all[static_cast<std::size_t>(n - kFewest)] = impulses_of_order(n);
    return all;
  }();
  const int n = static_cast<int>(std::ceil(kFewest + 0.95 * duration_samples));
  return n >= kFewest && n <= kMostKept ? kept[static_cast<std::size_t>(n - kFewest)] : impulses_of_order(n);
}

}  // namespace bouncelab
