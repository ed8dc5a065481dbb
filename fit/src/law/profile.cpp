// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/profile.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

namespace bouncelab::fit {
namespace {

constexpr double kZ95 = 1.959963984540054;

struct Root {
  double t;  ///< in standard errors
  double r;  ///< signed root of twice the fall of the log-likelihood
};

/// t at which r = z, by the parabola through the three points nearest to z.
double inverse(std::vector<Root> points, double z) {
  std::sort(points.begin(), points.end(),
            [&](const Root& a, const Root& b) { return std::abs(a.r - z) < std::abs(b.r - z); });
  const auto [t0, r0] = points[0];
  const auto [t1, r1] = points[1];
  const auto [t2, r2] = points[2];
  return t0 * (z - r1) * (z - r2) / ((r0 - r1) * (r0 - r2)) + t1 * (z - r0) * (z - r2) / ((r1 - r0) * (r1 - r2)) +
         t2 * (z - r0) * (z - r1) / ((r2 - r0) * (r2 - r1));
}

/// One side (sign -1 or +1) of the profile.
std::optional<std::vector<Root>> roots_of_side(const LogLikelihood& loglik, const Maximum& maximum,
                                               const Eigen::VectorXd& along, const Eigen::MatrixXd& across,
                                               double sign) {
  std::vector<Root> points{{0.0, 0.0}};
  Eigen::VectorXd z = Eigen::VectorXd::Zero(across.cols());
  for (double t = 1.0; t < 9.0 && (t < 3.0 || points.back().r < 0.97 * kZ95); t *= 2.0) {
    const Eigen::VectorXd base = maximum.x + sign * t * along;
    const LogLikelihood others = [&](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
      const double value = loglik(base + across * x, gradient);
      if (gradient) *gradient = (across.transpose() * *gradient).eval();
      return value;
    };
    // the path of the others bends like t^2
    const Eigen::VectorXd start = t > 1.0 ? Eigen::VectorXd(4.0 * z) : z;
    double best = 0.0;
    if (across.cols() == 0) {
      best = others(start, nullptr);
    } else {
      const Maximum there = maximise(others, start, Eigen::MatrixXd::Identity(across.cols(), across.cols()), 0.02);
      if (there.gain_left > 0.01) return std::nullopt;
      best = there.loglik;
      z = there.x;
    }
    points.push_back({t, std::sqrt(std::max(0.0, 2.0 * (maximum.loglik - best)))});
    if (!(points.back().r > points[points.size() - 2].r)) return std::nullopt;
  }
  // two standard errors nearly always reach z = 1.96, give or take what the parabola may extrapolate
  if (points.back().r < 0.97 * kZ95) return std::nullopt;
  return points;
}

}  // namespace

std::optional<ProfileIntervals> profile_intervals(const LogLikelihood& loglik, const Maximum& maximum,
                                                  const Eigen::MatrixXd& white, const Eigen::VectorXd& direction) {
  const Eigen::VectorXd in_y = white.transpose() * direction;
  const double se = in_y.norm();
  if (!(se > 0.0)) return std::nullopt;
  const Eigen::MatrixXd rotation = Eigen::HouseholderQR<Eigen::MatrixXd>(in_y).householderQ();
  const Eigen::VectorXd along = white * in_y / se;
  const Eigen::MatrixXd across = white * rotation.rightCols(direction.size() - 1);
  const auto below = roots_of_side(loglik, maximum, along, across, -1.0);
  const auto above = roots_of_side(loglik, maximum, along, across, 1.0);
  if (!below || !above) return std::nullopt;
  return ProfileIntervals{{-se * inverse(*below, 1.0), se * inverse(*above, 1.0)},
                          {-se * inverse(*below, kZ95), se * inverse(*above, kZ95)}};
}

}  // namespace bouncelab::fit
