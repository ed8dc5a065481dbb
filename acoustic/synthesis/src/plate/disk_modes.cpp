// SPDX-License-Identifier: GPL-3.0-or-later
#include "plate/disk_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/quadrature.hpp"
#include "plate/bessel.hpp"

namespace bouncelab::synthesis {
namespace {

double j_slope(int n, double x) { return n / x * bessel_j(n, x) - bessel_j(n + 1, x); }
double i_slope(int n, double x) { return n / x * bessel_i(n, x) + bessel_i(n + 1, x); }

/// Bending moment and Kelvin-Kirchhoff force at the edge, lambda = k a, for the two Bessel parts of the shape. The
/// parts with I_n are divided by I_n(lambda), which grows like exp(lambda).
struct EdgeConditions {
  double moment_j, moment_i, force_j, force_i;

  EdgeConditions(int n, double lambda, double nu) {
    const double square = static_cast<double>(n) * n;
    const double j = bessel_j(n, lambda), dj = j_slope(n, lambda);
    const double di = i_slope(n, lambda) / bessel_i(n, lambda);
    moment_j = lambda * lambda * j + (1.0 - nu) * (lambda * dj - square * j);
    moment_i = lambda * lambda - (1.0 - nu) * (lambda * di - square);
    force_j = lambda * lambda * lambda * dj + (1.0 - nu) * square * (lambda * dj - j);
    force_i = lambda * lambda * lambda * di - (1.0 - nu) * square * (lambda * di - 1.0);
  }
  double determinant() const { return moment_j * force_i - moment_i * force_j; }
};

double radial(const DiskMode& mode, double r_m) {
  const double x = mode.wavenumber_per_m * r_m;
  return bessel_j(mode.n_diameters, x) + mode.mix * bessel_i(mode.n_diameters, x);
}

DiskMode mode_at_root(int n, double lambda, double radius_m, double nu) {
  const EdgeConditions edge(n, lambda, nu);
  DiskMode mode{n, lambda / radius_m, edge.moment_j / (edge.moment_i * bessel_i(n, lambda)), 1.0, 0.0};
  const QuadratureRule rule = gauss_legendre(64, 0.0, radius_m);
  double mean_square = 0.0;
  for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
    const double value = radial(mode, rule.nodes[k]);
    mean_square += rule.weights[k] * value * value * 2.0 * rule.nodes[k] / (radius_m * radius_m);
  }
  mode.scale = 1.0 / std::sqrt(mean_square * (n == 0 ? 1.0 : 0.5));
  return mode;
}

}  // namespace

std::vector<DiskMode> free_disk_modes(double radius_m, double poisson_ratio, double max_wavenumber_per_m) {
  const double max_lambda = max_wavenumber_per_m * radius_m;
  constexpr double kStep = 0.05;  // roots of one n are about pi apart
  std::vector<DiskMode> modes;
  for (int n = 0; n <= static_cast<int>(max_lambda) + 1; ++n) {
    const auto f = [&](double lambda) { return EdgeConditions(n, lambda, poisson_ratio).determinant(); };
    // below 1 stand the rigid-body solutions, at lambda = 0; the lowest flexural root is 2.2
    double lo = 1.0, f_lo = f(lo);
    for (double hi = lo + kStep; hi <= max_lambda; hi += kStep) {
      const double f_hi = f(hi);
      if (f_lo * f_hi < 0.0) {
        double a = lo, b = hi;
        for (int halving = 0; halving < 50; ++halving) {
          const double middle = 0.5 * (a + b);
          (f(middle) * f_lo > 0.0 ? a : b) = middle;
        }
        modes.push_back(mode_at_root(n, 0.5 * (a + b), radius_m, poisson_ratio));
        if (n > 0) {
          modes.push_back(modes.back());
          modes.back().phase_rad = 0.5 * std::numbers::pi;
        }
      }
      lo = hi;
      f_lo = f_hi;
    }
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const auto& a, const auto& b) { return a.wavenumber_per_m < b.wavenumber_per_m; });
  return modes;
}

void disk_shapes_at(const std::vector<DiskMode>& modes, double x_m, double y_m, std::span<double> shapes) {
  const double r_m = hypot(x_m, y_m), theta = atan2(y_m, x_m);
  for (std::size_t k = 0; k < modes.size(); ++k)
    shapes[k] = modes[k].scale * radial(modes[k], r_m) * cos(modes[k].n_diameters * theta - modes[k].phase_rad);
}

}  // namespace bouncelab::synthesis
