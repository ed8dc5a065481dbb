// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/offsets.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kCloseEnough = 1e-3;  // of a standard error: costs 1e-6 of the log-likelihood
constexpr int kMostSteps = 60;

/// Derivative of the log-likelihood by the offset, and the sum of the squares of the samples' own.
struct Score {
  double sum = 0.0, squares = 0.0;
};

struct Point {
  double x = 0.0;
  Score score;
};

/// Where the score is 0. It falls but for samples so far off that they count as lost: from `start`, which is amidst
/// the samples, steps of at most twice their scatter find a change of sign, regula falsi (Illinois) the place.
template <class Function>
Point root_of(const Function& score_at, double start, double n) {
  Point a{start, score_at(start)}, b = a;
  const auto is_close = [](const Point& p) {
    return std::abs(p.score.sum) <= kCloseEnough * std::sqrt(p.score.squares);
  };
  for (int k = 0; k < kMostSteps && a.score.sum * b.score.sum >= 0.0; ++k) {
    if (is_close(b) || !(b.score.squares > 0.0)) return b;
    a = b;
    const double most = 2.0 * std::sqrt(n / a.score.squares);
    b.x = a.x + std::clamp(a.score.sum / a.score.squares, -most, most);
    b.score = score_at(b.x);
  }
  double at_a = a.score.sum, at_b = b.score.sum;
  for (int k = 0; k < kMostSteps && !is_close(b); ++k) {
    if (std::abs(b.x - a.x) * std::sqrt(b.score.squares) < kCloseEnough) break;
    Point c;
    c.x = b.x - at_b * (b.x - a.x) / (at_b - at_a);
    c.score = score_at(c.x);
    if (c.score.sum * at_b < 0.0) {
      a = b;
      at_a = at_b;
    } else {
      at_a *= 0.5;
    }
    b = c;
    at_b = c.score.sum;
  }
  return b;
}

}  // namespace

OffsetLikelihood::OffsetLikelihood(const LawData& data, const Groups& groups, const LawModel& model,
                                   const ScatterFamily& scatter)
    : data_(data),
      shifted_(data),
      likelihood_(shifted_, model, scatter),
      reference_(groups.reference),
      members_(groups.n_groups),
      offsets_(groups.n_groups) {
  for (std::size_t k = 0; k < groups.of_sample.size(); ++k) members_[groups.of_sample[k]].push_back(k);
}

OffsetLikelihood::Offset OffsetLikelihood::best_offset(const Eigen::VectorXd& theta, std::size_t group) {
  const std::vector<std::size_t>& members = members_[group];
  const auto score_at = [&](double offset) {
    Score score;
    for (const std::size_t k : members) {
      shifted_.eps[k] = data_.eps[k] - offset;
      const double s = likelihood_.density(theta, k).d_location;
      score.sum += s;
      score.squares += s * s;
    }
    return score;
  };
  if (group == reference_) return {0.0, 1.0 / std::sqrt(score_at(0.0).squares)};
  std::vector<double> residuals;
  for (const std::size_t k : members) residuals.push_back(data_.eps[k] - likelihood_.eps_of(theta, k));
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  const Point best = root_of(score_at, *middle, static_cast<double>(members.size()));
  return {best.x, 1.0 / std::sqrt(best.score.squares)};
}

double OffsetLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) {
  if (!theta.allFinite()) return -HUGE_VAL;
  parallel_for(members_.size(), 0, [&](std::size_t g) {
    offsets_[g] = best_offset(theta, g);
    for (const std::size_t k : members_[g]) shifted_.eps[k] = data_.eps[k] - offsets_[g].value;
  });
  return likelihood_(theta, gradient);
}

std::size_t rank_with_offsets(const LawData& data, const LawModel& model, const Eigen::VectorXd& q,
                              const Groups& groups) {
  constexpr double kIndependent = 1e-9;  // of the unit diagonal
  const Eigen::MatrixXd x = model.jacobian(data.v_mps, q);
  Eigen::MatrixXd products = x.transpose() * x;
  const Eigen::VectorXd scale = products.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(x.cols(), static_cast<Eigen::Index>(groups.n_groups));
  Eigen::VectorXd n = Eigen::VectorXd::Zero(sums.cols());
  for (std::size_t k = 0; k < groups.of_sample.size(); ++k) {
    if (groups.of_sample[k] == groups.reference) continue;
    const auto g = static_cast<Eigen::Index>(groups.of_sample[k]);
    sums.col(g) += x.row(static_cast<Eigen::Index>(k)).transpose();
    n[g] += 1.0;
  }
  n[static_cast<Eigen::Index>(groups.reference)] = 1.0;
  products -= sums * n.cwiseInverse().asDiagonal() * sums.transpose();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * products * scale.asDiagonal();
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues();
  return groups.n_groups - 1 + static_cast<std::size_t>((eigenvalues.array() > kIndependent).count());
}

}  // namespace bouncelab::fit
