// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/profile.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "law/distributions.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kReached = 0.97;  // of a level: that little a parabola may extrapolate

struct Root {
  double t;  ///< in standard errors
  double r;  ///< signed root of twice the fall of the log-likelihood
};

/// Where r = z: by the parabola through the three points nearest to z, and by the straight line between those on either
/// side of z. Where r bends sharply the parabola may leave the interval between these: then the line's.
struct Crossing {
  double t;
  double t_line;
};

/// @param points  at least 3, t and r increasing from 0
Crossing crossing(const std::vector<Root>& points, double z) {
  std::vector<Root> nearest = points;
  std::sort(nearest.begin(), nearest.end(),
            [&](const Root& a, const Root& b) { return std::abs(a.r - z) < std::abs(b.r - z); });
  const auto [t0, r0] = nearest[0];
  const auto [t1, r1] = nearest[1];
  const auto [t2, r2] = nearest[2];
  const double t = t0 * (z - r1) * (z - r2) / ((r0 - r1) * (r0 - r2)) +
                   t1 * (z - r0) * (z - r2) / ((r1 - r0) * (r1 - r2)) +
                   t2 * (z - r0) * (z - r1) / ((r2 - r0) * (r2 - r1));
  const auto above = std::find_if(points.begin() + 1, points.end() - 1, [&](const Root& p) { return p.r > z; });
  const Root &lo = *(above - 1), &hi = *above;
  const double line = lo.t + (hi.t - lo.t) * (z - lo.r) / (hi.r - lo.r);
  const bool is_between = t >= lo.t && (t <= hi.t || z > hi.r);
  return {is_between ? t : line, line};
}

/// One side (sign -1 or +1) of the profile.
class Side {
 public:
  Side(const LogLikelihood& loglik, const Maximum& maximum, const Eigen::VectorXd& along, const Eigen::MatrixXd& across,
       double sign)
      : loglik_(loglik), maximum_(maximum), along_(sign * along), across_(across) {
    z_ = Eigen::VectorXd::Zero(across.cols());
  }

  /// t where the root is z68 and z95.
  std::optional<std::pair<double, double>> ends(const ProfileLevels& levels) {
    // the signed root is nearly linear: from where it is near the inner level a secant leads near the outer one
    double t = std::min(2.0, levels.z68);
    do {
      if (t > 200.0 || !add(t)) return std::nullopt;
      const Root& last = points_.back();
      t = std::clamp(last.t * levels.z95 / last.r, 1.25 * last.t, 2.5 * last.t);
    } while (points_.size() < 3 || points_.back().r < kReached * levels.z95);
    const auto z68 = end(levels.z68), z95 = end(levels.z95);
    return z68 && z95 && *z68 < *z95 ? std::optional(std::pair(*z68, *z95)) : std::nullopt;
  }

 private:
  bool add(double t) {
    const Eigen::VectorXd base = maximum_.x + t * along_;
    const LogLikelihood others = [&](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
      const double value = loglik_(base + across_ * x, gradient);
      if (gradient) *gradient = (across_.transpose() * *gradient).eval();
      return value;
    };
    // the path of the others bends like t^2
    const Eigen::VectorXd start = z_ * square(t / t_of_z_);
    double best = 0.0;
    if (across_.cols() == 0) {
      best = others(start, nullptr);
    } else {
      const Maximum there = maximise(others, start, Eigen::MatrixXd::Identity(across_.cols(), across_.cols()), 0.02);
      if (there.gain_left > 0.01) return false;
      best = there.loglik;
      z_ = there.x;
    }
    t_of_z_ = t;
    points_.push_back({t, std::sqrt(std::max(0.0, 2.0 * (maximum_.loglik - best)))});
    std::sort(points_.begin(), points_.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
    return std::adjacent_find(points_.begin(), points_.end(),
                              [](const Root& a, const Root& b) { return !(b.r > a.r); }) == points_.end();
  }

  /// More points are taken until parabola and line agree to a twentieth: the parabola is nearer than their difference,
  /// and the levels themselves, which are of a normal distribution, are no better.
  std::optional<double> end(double z) {
    constexpr double kAgreement = 0.05;
    constexpr int kMostPoints = 12;
    for (int k = 0; k < kMostPoints; ++k) {
      const Crossing here = crossing(points_, z);
      if (std::abs(here.t - here.t_line) <= kAgreement * here.t) return here.t;
      if (!add(0.5 * (here.t + here.t_line))) return std::nullopt;
    }
    return std::nullopt;
  }

  const LogLikelihood& loglik_;
  const Maximum& maximum_;
  Eigen::VectorXd along_;
  const Eigen::MatrixXd& across_;
  std::vector<Root> points_{{0.0, 0.0}};
  Eigen::VectorXd z_;  ///< of the others, where they were sought last
  double t_of_z_ = 1.0;
};

}  // namespace

ProfileLevels profile_levels(std::size_t n, std::size_t n_location) {
  const double free = std::max(1.0, static_cast<double>(n) - static_cast<double>(n_location));
  const auto level = [&](double p) {
    return std::sqrt(static_cast<double>(n) * log1p(square(student_t_quantile(p, free)) / free));
  };
  return {level(0.8413447460685429), level(0.975)};
}

std::optional<ProfileIntervals> profile_intervals(const LogLikelihood& loglik, const Maximum& maximum,
                                                  const Eigen::MatrixXd& white, const Eigen::VectorXd& direction,
                                                  const ProfileLevels& levels) {
  const Eigen::VectorXd in_y = white.transpose() * direction;
  const double se = in_y.norm();
  if (!(se > 0.0)) return std::nullopt;
  const Eigen::MatrixXd rotation = Eigen::HouseholderQR<Eigen::MatrixXd>(in_y).householderQ();
  const Eigen::VectorXd along = white * in_y / se;
  const Eigen::MatrixXd across = white * rotation.rightCols(direction.size() - 1);
  const auto below = Side(loglik, maximum, along, across, -1.0).ends(levels);
  const auto above = Side(loglik, maximum, along, across, 1.0).ends(levels);
  if (!below || !above) return std::nullopt;
  return ProfileIntervals{{-se * below->first, se * above->first}, {-se * below->second, se * above->second}};
}

}  // namespace bouncelab::fit
