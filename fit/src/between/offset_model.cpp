// SPDX-License-Identifier: GPL-3.0-or-later
#include "between/offset_model.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

/// With scaling, so that the columns' units do not matter.
Eigen::MatrixXd inverse_of_positive(const Eigen::MatrixXd& m, double& log_det) {
  const Eigen::VectorXd scale = m.diagonal().array().max(1e-300).sqrt().inverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * m * scale.asDiagonal();
  const Cholesky root = cholesky(scaled).value();
  log_det += root.log_determinant() - 2.0 * scale.array().unaryExpr([](double s) { return log(s); }).sum();
  return scale.asDiagonal() * root.inverse() * scale.asDiagonal();
}

}  // namespace

OffsetSolution::OffsetSolution(const OffsetData& data, const Deviations& deviations)
    : data_(data), deviations_(deviations) {
  const Eigen::Index n_fixed = data.n_fixed();
  weights_ = (data.variance.array() + square(deviations[0])).inverse();
  log_det_ = -weights_.array().log().sum();
  // with f = [h, m]: f'Wf, Z'Wf and the blocks of M
  const OffsetData::Rows weighted = weights_.asDiagonal() * data.h_and_m;
  Eigen::MatrixXd products = data.h_and_m.transpose() * weighted;
  std::array<Eigen::MatrixXd, 2> t;
  std::array<Eigen::VectorXd, 2> d;
  for (std::size_t g = 0; g < 2; ++g) {
    active_[g] = data.n_levels[g] > 0 && deviations[g + 1] > 0.0;
    const int n_levels = active_[g] ? data.n_levels[g] : 0;
    t[g] = Eigen::MatrixXd::Zero(n_levels, n_fixed + 1);
    d[g] = Eigen::VectorXd::Constant(n_levels, active_[g] ? 1.0 / square(deviations[g + 1]) : 0.0);
    if (active_[g]) log_det_ += 2.0 * n_levels * log(deviations[g + 1]);
  }
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(d[0].size(), d[1].size());
  for (Eigen::Index r = 0; r < data.n(); ++r) {
    const std::array<int, 2> level = data.levels_of(r);
    for (std::size_t g = 0; g < 2; ++g) {
      if (!has(g, level[g])) continue;
      d[g][level[g]] += weights_[r];
      t[g].row(level[g]) += weighted.row(r);
    }
    if (has(0, level[0]) && has(1, level[1])) both(level[0], level[1]) += weights_[r];
  }
  for (const double one : d[0]) log_det_ += log(one);
  inverse_ = d[0].cwiseInverse();
  shared_ = inverse_.asDiagonal() * both;
  const Eigen::MatrixXd schur = Eigen::MatrixXd(d[1].asDiagonal()) - transposed_product(both, shared_);
  schur_inverse_ = schur.size() > 0 ? inverse_of_positive(schur, log_det_) : schur;
  u_[1] = product(schur_inverse_, t[1] - transposed_product(shared_, t[0]));
  u_[0] = inverse_.asDiagonal() * t[0] - product(shared_, u_[1]);
  for (std::size_t g = 0; g < 2; ++g)
    if (active_[g]) products -= transposed_product(t[g], u_[g]);
  const Eigen::MatrixXd information = products.topLeftCorner(n_fixed, n_fixed);
  const Eigen::VectorXd right = products.topRightCorner(n_fixed, 1);
  double log_det_information = 0.0;
  covariance_ = inverse_of_positive(0.5 * (information + information.transpose()), log_det_information);
  beta_ = product(covariance_, right);
  sum_of_squares_ = products(n_fixed, n_fixed) - beta_.dot(right);
  minus_two_log_likelihood_ = log_det_ + log_det_information + sum_of_squares_;
}

double OffsetSolution::effect(std::size_t grouping, int level) const {
  if (!has(grouping, level)) return 0.0;
  const auto row = u_[grouping].row(level);
  return row[data_.n_fixed()] - row.head(data_.n_fixed()).dot(beta_);
}

double OffsetSolution::inverse_of(const std::array<int, 2>& level) const {
  double sum = 0.0;
  if (has(0, level[0])) sum += inverse_[level[0]] + congruence(shared_.row(level[0]).transpose(), schur_inverse_)(0, 0);
  if (has(1, level[1])) sum += schur_inverse_(level[1], level[1]);
  if (has(0, level[0]) && has(1, level[1])) sum -= 2.0 * shared_.row(level[0]).dot(schur_inverse_.col(level[1]));
  return sum;
}

OffsetSolution::Residual OffsetSolution::without(Eigen::Index r) const {
  const Eigen::Index n_fixed = data_.n_fixed();
  const std::array<int, 2> level = data_.levels_of(r);
  Eigen::RowVectorXd row = data_.h_and_m.row(r);
  for (std::size_t g = 0; g < 2; ++g)
    if (has(g, level[g])) row -= u_[g].row(level[g]);
  row *= weights_[r];  // of V^-1 f
  const Eigen::RowVectorXd of_h = row.head(n_fixed);
  // diagonal of P and element of P m: the offset of a recording with a parameter of its own is their ratio
  const double p =
      weights_[r] - square(weights_[r]) * inverse_of(level) - congruence(of_h.transpose(), covariance_)(0, 0);
  const double p_m = row[n_fixed] - of_h.dot(beta_);
  return p > 1e-9 * weights_[r] ? Residual{p_m / p, 1.0 / std::sqrt(p)} : Residual{};
}

OffsetSolution::Residual OffsetSolution::of_another(const Eigen::RowVectorXd& h, double m, double variance,
                                                    const std::array<int, 2>& level) const {
  Eigen::RowVectorXd row = h;
  double value = m - h.dot(beta_);
  for (std::size_t g = 0; g < 2; ++g)
    if (has(g, level[g])) {
      row -= u_[g].row(level[g]).head(data_.n_fixed());
      value -= effect(g, level[g]);
    }
  const double of_new_levels = (data_.n_levels[0] > 0 && !has(0, level[0]) ? square(deviations_[1]) : 0.0) +
                               (data_.n_levels[1] > 0 && !has(1, level[1]) ? square(deviations_[2]) : 0.0);
  return {value, std::sqrt(variance + square(deviations_[0]) + of_new_levels + inverse_of(level) +
                           congruence(row.transpose(), covariance_)(0, 0))};
}

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
  const Eigen::VectorXd residuals = data.m() - data.h() * solution.beta();
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
