// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/variance_components.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "numerics/distributions.hpp"
#include "numerics/linalg.hpp"

namespace bouncelab::fit {
namespace {

double minus_two_ln(const OffsetData& data, const Deviations& deviations) {
  return OffsetSolution(data, deviations).minus_two_log_likelihood();
}

bool exists(const OffsetData& data, std::size_t k) { return k == 0 || data.n_levels[k - 1] > 0; }

/// The least of a function between a and c, by golden sections. @param tolerance  of its place
double least_between(const std::function<double(double)>& f, double a, double c, double tolerance) {
  constexpr double kGolden = 0.3819660112501051;
  double x = a + kGolden * (c - a), y = c - kGolden * (c - a);
  double f_x = f(x), f_y = f(y);
  while (c - a > tolerance) {
    if (f_x <= f_y) {
      c = y, y = x, f_y = f_x;
      f_x = f(x = a + kGolden * (c - a));
    } else {
      a = x, x = y, f_x = f_y;
      f_y = f(y = c - kGolden * (c - a));
    }
  }
  return 0.5 * (a + c);
}

/// Robust against a few recordings that are far off; not 0 where the errors are not.
double scale_of(const OffsetData& data) {
  const OffsetSolution solution(data, {0.0, 0.0, 0.0});
  const Eigen::VectorXd residuals = data.m - data.h * solution.beta();
  return std::sqrt(residuals.squaredNorm() / static_cast<double>(data.n()) + data.variance.minCoeff());
}

/// Best value of one standard deviation, the others as they are: on a grid from 0, then between the best one's
/// neighbours.
double best_one(const OffsetData& data, Deviations deviations, std::size_t k, double scale) {
  const auto f = [&](double sd) {
    deviations[k] = sd;
    return minus_two_ln(data, deviations);
  };
  std::vector<double> grid{0.0};
  for (double sd = scale / 128.0; sd < 5.0 * scale; sd *= 2.0) grid.push_back(sd);
  std::vector<double> values;
  for (const double sd : grid) values.push_back(f(sd));
  const auto best = static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin());
  const double lo = grid[best > 0 ? best - 1 : 0], hi = grid[std::min(best + 1, grid.size() - 1)];
  const double found = least_between(f, lo, hi, 1e-4 * hi);
  return f(found) < values[0] ? found : 0.0;
}

/// A step of Newton's method by the logarithm. @return nullopt where it would lead far, or to no minimum
std::optional<double> near_step(const OffsetData& data, Deviations deviations, std::size_t k) {
  constexpr double kStep = 0.1, kFar = 0.7;
  const double here = deviations[k];
  const auto f = [&](double steps) {
    deviations[k] = here * exp(kStep * steps);
    return minus_two_ln(data, deviations);
  };
  const double behind = f(-1.0), middle = f(0.0), ahead = f(1.0), curvature = ahead - 2.0 * middle + behind;
  const double step = -0.5 * (ahead - behind) / curvature * kStep;
  return curvature > 0.0 && std::abs(step) < kFar ? std::optional(here * exp(step)) : std::nullopt;
}

/// The others at their best beside a fixed one.
Deviations with_fixed(const OffsetData& data, Deviations deviations, std::optional<std::size_t> fixed, double scale) {
  constexpr int kMostRounds = 30;
  std::size_t n_free = 0;
  for (std::size_t k = 0; k < deviations.size(); ++k) n_free += exists(data, k) && k != fixed;
  for (int round = 0; round < kMostRounds; ++round) {
    double moved = 0.0;
    for (std::size_t k = 0; k < deviations.size(); ++k) {
      if (!exists(data, k) || k == fixed) continue;
      const bool is_near = round > 0 || fixed;
      const auto step = is_near && deviations[k] > 0.02 * scale ? near_step(data, deviations, k) : std::nullopt;
      const double next = step ? *step : best_one(data, deviations, k, scale);
      moved = std::max(moved, std::abs(next - deviations[k]));
      deviations[k] = next;
    }
    if (n_free < 2 || moved < 1e-3 * scale) break;
  }
  return deviations;
}

}  // namespace

Deviations restricted_maximum(const OffsetData& data) {
  const double scale = scale_of(data);
  Deviations start{};
  for (std::size_t k = 0; k < start.size(); ++k) start[k] = exists(data, k) ? 0.5 * scale : 0.0;
  return with_fixed(data, start, std::nullopt, scale);
}

Interval profile_interval(const OffsetData& data, const Deviations& best, std::size_t k) {
  const double level = square(student_t_quantile(0.975, std::max(1.0, static_cast<double>(data.n() - data.n_fixed()))));
  const double scale = scale_of(data), least = minus_two_ln(data, best);
  Deviations near = best;
  const auto above = [&](double sd) {
    near[k] = sd;
    near = with_fixed(data, near, k, scale);
    return minus_two_ln(data, near) - least - level;
  };
  /// Between a place inside the interval and one outside.
  const auto end_between = [&](double inside, double outside) {
    while (std::abs(outside - inside) > 2e-3 * std::max(inside, outside)) {
      const double middle = 0.5 * (inside + outside);
      (above(middle) < 0.0 ? inside : outside) = middle;
    }
    return 0.5 * (inside + outside);
  };
  Interval interval;
  if (best[k] > 0.0 && above(0.0) > 0.0) {
    near = best;
    interval.lo = end_between(best[k], 0.0);
  }
  double outside = std::max(2.0 * best[k], 1e-3 * scale);
  near = best;
  while (above(outside) < 0.0 && outside < 1e6 * scale) outside *= 2.0;
  near = best;
  interval.hi = end_between(best[k], outside);
  return interval;
}

ErrorsOfErrors::ErrorsOfErrors(const OffsetData& data, const Deviations& best)
    : most_(std::max(1.0, static_cast<double>(data.n() - data.n_fixed()))),
      covariance_(OffsetSolution(data, best).covariance()) {
  constexpr double kStep = 0.1;  // of the logarithm of a variance
  const double scale = scale_of(data);
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < best.size(); ++k)
    if (best[k] > 1e-3 * scale) {
      used.push_back(k);
      variances_.push_back(square(best[k]));
    }
  tau_is_first_ = !used.empty() && used.front() == 0;
  const auto at = [&](std::size_t i, double steps_i, std::size_t j, double steps_j) {
    Deviations deviations = best;
    deviations[used[i]] *= exp(0.5 * kStep * steps_i);
    deviations[used[j]] *= exp(0.5 * kStep * steps_j);
    return OffsetSolution(data, deviations);
  };
  const auto n = static_cast<Eigen::Index>(used.size());
  Eigen::MatrixXd curvature(n, n);  // of ln L, sign reversed
  for (std::size_t i = 0; i < used.size(); ++i) {
    const OffsetSolution ahead = at(i, 1.0, i, 0.0), behind = at(i, -1.0, i, 0.0);
    derivatives_.push_back((ahead.covariance() - behind.covariance()) / (2.0 * kStep));
    for (std::size_t j = 0; j <= i; ++j) {
      const auto value = [&](double a, double b) { return at(i, a, j, b).minus_two_log_likelihood(); };
      const double second =
          i == j ? ahead.minus_two_log_likelihood() + behind.minus_two_log_likelihood() - 2.0 * minus_two_ln(data, best)
                 : 0.25 * (value(1, 1) - value(1, -1) - value(-1, 1) + value(-1, -1));
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      curvature(a, b) = curvature(b, a) = 0.5 * second / square(kStep);
    }
  }
  const std::optional<Cholesky> root = n > 0 ? cholesky(curvature) : std::nullopt;
  if (root)
    covariance_of_logs_ = root->inverse();
  else
    derivatives_.clear();
}

double ErrorsOfErrors::satterthwaite(const Eigen::VectorXd& gradient, double variance) const {
  const double spread = gradient.dot(covariance_of_logs_ * gradient);
  return std::clamp(spread > 0.0 ? 2.0 * square(variance) / spread : most_, 1.0, most_);
}

double ErrorsOfErrors::degrees_of_freedom(const Eigen::VectorXd& direction) const {
  return degrees_of_freedom(direction, 0.0);
}

double ErrorsOfErrors::degrees_of_freedom(const Eigen::VectorXd& direction, double se) const {
  if (derivatives_.empty()) return most_;
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(derivatives_.size()));
  for (std::size_t k = 0; k < derivatives_.size(); ++k)
    gradient[static_cast<Eigen::Index>(k)] =
        direction.dot(derivatives_[k] * direction) + (se > 0.0 ? variances_[k] : 0.0);
  return satterthwaite(gradient, se > 0.0 ? square(se) : direction.dot(covariance_ * direction));
}

double ErrorsOfErrors::degrees_of_freedom_of_a_recording(double se) const {
  if (derivatives_.empty() || !tau_is_first_) return most_;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(derivatives_.size()));
  gradient[0] = variances_[0];
  return satterthwaite(gradient, square(se));
}

}  // namespace bouncelab::fit
