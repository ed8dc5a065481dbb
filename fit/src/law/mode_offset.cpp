// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/mode_offset.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "law/normal_laplace.hpp"

namespace bouncelab::fit {
namespace {

struct LogRatio {
  double value;   ///< log of Mills' ratio R(u)
  double hazard;  ///< -d log R / du = 1/R(u) - u, positive
};

LogRatio log_mills_ratio(double u) {
  const double ratio =
      u >= 0.0 ? mills_ratio(u) : std::sqrt(2.0 * std::numbers::pi) * exp(0.5 * u * u) - mills_ratio(-u);
  return {log(ratio), 1.0 / ratio - u};
}

}  // namespace

/// f' = 0 where R(p - z) / b_above = R(q + z) / b_below, p = tau / b_above, q = tau / b_below, z = distance / tau: of
/// its logarithm, which is nearly linear in z, by Newton's method. Derivatives by those of the equation.
ModeOffset mode_offset(double asymmetry, double rho, double near) {
  constexpr double kMostRho = 8.0;  // from there on the mean of the exponentials, to 1e-6
  constexpr int kMost = 30;
  rho = std::min(rho, kMostRho);
  const double tau = exp(rho), p = exp(rho - 0.5 * asymmetry), q = exp(rho + 0.5 * asymmetry);
  double z = near / tau;
  LogRatio above{}, below{};
  for (int i = 0; i < kMost; ++i) {
    above = log_mills_ratio(p - z);
    below = log_mills_ratio(q + z);
    const double step = -(above.value - below.value - asymmetry) / (above.hazard + below.hazard);
    z += step;
    if (std::abs(step) < 1e-12 * (1.0 + std::abs(z))) break;
  }
  const double by_z = above.hazard + below.hazard;
  const double by_asymmetry = 0.5 * (p * above.hazard + q * below.hazard) - 1.0;
  const double by_rho = q * below.hazard - p * above.hazard;
  return {tau * z, -tau * by_asymmetry / by_z, tau * (z - by_rho / by_z)};
}

}  // namespace bouncelab::fit
