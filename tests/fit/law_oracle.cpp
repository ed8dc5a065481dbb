// SPDX-License-Identifier: GPL-3.0-or-later
#include "law_oracle.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <span>

namespace bouncelab::testing {
namespace {

constexpr double kKappaSpread = 0.1;  // as drawn

struct SpeedAndEps {
  double v_mps, eps;
};

/// Of two successive intervals, with these factors of drag and contact time.
SpeedAndEps sample_at_plate(const DrawnBall& ball, double before_s, double after_s, double ln_kappa, double ln_tau) {
  const FlightTable& flights = flights_of(ball);
  const double kappa_factor = std::exp(ln_kappa);
  const auto tau_s = [&](double v) { return std::exp(ln_tau) * ball.tau_1_s * std::pow(v, ball.tau_exponent); };
  SpeedAndEps sample{0.0, after_s / before_s};
  double up_mps = 0.5 * kDrawnGravity_mps2 * before_s;
  // the contact before the flight was at up/eps of the impact before, about that of this one; three rounds, for the
  // flight is not all of the interval
  for (int i = 0; i < 3; ++i) {
    up_mps = flights.launch_mps(before_s - tau_s(up_mps / std::clamp(sample.eps, 0.2, 1.0)), kappa_factor);
    sample.v_mps = flights.at(up_mps, kappa_factor).landing_mps;
    sample.eps = flights.launch_mps(after_s - tau_s(sample.v_mps), kappa_factor) / sample.v_mps;
  }
  return sample;
}

/// The impacts of one drop: times as heard, and as they were.
struct HeardDrop {
  std::span<const Onset> onsets;
  std::span<const double> exact_s;
  std::size_t number;
};

/// What is sought: the law's constants, ln kappa, ln tau and, of one drop with a loss of its own, that in standard
/// deviations of the scatter. The last three are known beforehand to be 0 within their spreads.
class Oracle {
 public:
  Oracle(const Cell& cell, const DrawnTable& table)
      : cell_(cell), table_(table), law_(cell.its_law()), ball_(cell.its_ball()) {
    n_constants_ = static_cast<Eigen::Index>(law_.constants.size());
    const bool has_own = cell.n_drops == 1 && cell.along == AlongDrop::offset;
    rest_ = Eigen::VectorXd::Zero(has_own ? 3 : 2);
    rest_[0] = std::log(table.kappa_factor);
    rest_[1] = std::log(table.tau_factor);
    if (has_own) rest_[2] = table.offsets[0];
    constexpr int kSteps = 3;  // of Gauss and Newton, from the truth: drag and contact time act not quite linearly
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::VectorXd step = next_step();
      more_ = step.head(n_constants_);
      rest_ += step.tail(rest_.size());
    }
  }

  OracleEstimate at(double v_mps) const {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n_constants_ + rest_.size());
    row.head(n_constants_) = by_constants(v_mps);
    if (rest_.size() > 2) row[n_constants_ + 2] = cell_.scatter_at(v_mps);
    return {eps(v_mps) + row.head(n_constants_).dot(more_), std::sqrt(row.dot(information_.solve(row)))};
  }

 private:
  double eps(double v_mps) const {
    const double own = rest_.size() > 2 ? rest_[2] * cell_.scatter_at(v_mps) : 0.0;
    return law_.eps(v_mps, law_.constants) + own;
  }

  SpeedAndEps sample(double before_s, double after_s, double more_kappa, double more_tau) const {
    return sample_at_plate(ball_, before_s, after_s, rest_[0] + more_kappa, rest_[1] + more_tau);
  }

  /// From an impact to the next one, without a fluctuation.
  double interval_s(double v_mps) const {
    return std::exp(rest_[1]) * ball_.tau_1_s * std::pow(v_mps, ball_.tau_exponent) +
           flights_of(ball_).at(v_mps * eps(v_mps), std::exp(rest_[0])).duration_s;
  }

  /// d eps / d constants.
  Eigen::VectorXd by_constants(double v_mps) const {
    Eigen::VectorXd row(n_constants_);
    for (std::size_t i = 0; i < law_.constants.size(); ++i) {
      std::vector<double> up = law_.constants, down = up;
      constexpr double kStep = 1e-5;
      up[i] += kStep;
      down[i] -= kStep;
      row[static_cast<Eigen::Index>(i)] = (law_.eps(v_mps, up) - law_.eps(v_mps, down)) / (2.0 * kStep);
    }
    return row;
  }

  Eigen::VectorXd next_step() {
    const Eigen::Index n = n_constants_ + rest_.size();
    // constants that these speeds do not tell apart may be anywhere within 1
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    information.diagonal().head(n_constants_).setOnes();
    Eigen::VectorXd score = Eigen::VectorXd::Zero(n);
    const double spreads[] = {kKappaSpread, ball_.tau_spread, cell_.along_size};
    for (Eigen::Index i = 0; i < rest_.size(); ++i) {
      information(n_constants_ + i, n_constants_ + i) = 1.0 / (spreads[i] * spreads[i]);
      score[n_constants_ + i] = -rest_[i] / (spreads[i] * spreads[i]);
    }
    const std::vector<Onset>& all = table_.onsets;
    for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
      while (last < all.size() && all[last].drop == all[first].drop) ++last;
      if (last - first < 3) continue;
      add_drop({std::span(all).subspan(first, last - first), std::span(table_.exact_s).subspan(first, last - first),
                static_cast<std::size_t>(all[first].drop)},
               information, score);
    }
    information_.compute(information);
    return information_.solve(score);
  }

  void add_drop(const HeardDrop& drop, Eigen::MatrixXd& information, Eigen::VectorXd& score) const {
    const auto n = static_cast<Eigen::Index>(drop.onsets.size()) - 2;
    Eigen::MatrixXd design(n, score.size()), by_time = Eigen::MatrixXd::Zero(n, n + 2);
    Eigen::VectorXd residual(n), size(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      // Where weights went by the times as heard, a late impact would count more. And the flight after is that of the
      // law: with the fluctuation in it the derivatives by drag and contact time would go with the residual, which is
      // as much as the Jacobian of eps by the interval (of 60 drops of a superball
      // .7 standard errors of eps on average).
      const double before_s = drop.exact_s[k + 1] - drop.exact_s[k];
      const double v_mps = sample(before_s, drop.exact_s[k + 2] - drop.exact_s[k + 1], 0.0, 0.0).v_mps;
      const double after_s = interval_s(v_mps);
      const auto with = [&](double more_kappa, double more_tau) {
        return sample(before_s, after_s, more_kappa, more_tau);
      };
      const SpeedAndEps exact = with(0.0, 0.0);
      // at a point: no sample beside a step is to have a slope of its own
      const double h_mps = 1e-6 * exact.v_mps;
      const double slope = (eps(exact.v_mps + h_mps) - eps(exact.v_mps - h_mps)) / (2.0 * h_mps);
      const auto by = [&](const SpeedAndEps& less, const SpeedAndEps& more, double step) {
        return (slope * (more.v_mps - less.v_mps) - (more.eps - less.eps)) / step;
      };
      constexpr double kStep = 0.01;
      design.row(i).head(n_constants_) = by_constants(exact.v_mps).transpose();
      design(i, n_constants_) = by(with(-kStep, 0.0), with(kStep, 0.0), 2.0 * kStep);
      design(i, n_constants_ + 1) = by(with(0.0, -kStep), with(0.0, kStep), 2.0 * kStep);
      size[i] = cell_.scatter_at(exact.v_mps);
      if (rest_.size() > 2) design(i, n_constants_ + 2) = size[i];
      const double by_before = -exact.eps / before_s - 0.5 * kDrawnGravity_mps2 * slope;
      by_time(i, i) = -by_before;
      by_time(i, i + 1) = by_before - 1.0 / before_s;
      by_time(i, i + 2) = 1.0 / before_s;

      const SpeedAndEps heard = sample(drop.onsets[k + 1].t_s - drop.onsets[k].t_s,
                                       drop.onsets[k + 2].t_s - drop.onsets[k + 1].t_s, 0.0, 0.0);
      // a ratio of two noisy intervals is too large on average, to second order
      const double too_large = (1.0 + 2.0 * exact.eps) * std::pow(cell_.sigma_t_s / before_s, 2.0);
      residual[i] = heard.eps - too_large - eps(heard.v_mps);
    }
    const Eigen::MatrixXd covariance =
        scatter_covariance(size, drop.number) + cell_.sigma_t_s * cell_.sigma_t_s * by_time * by_time.transpose();
    const Eigen::LLT<Eigen::MatrixXd> root(covariance);
    information += design.transpose() * root.solve(design);
    score += design.transpose() * root.solve(residual);
  }

  Eigen::MatrixXd scatter_covariance(const Eigen::VectorXd& size, std::size_t drop) const {
    const bool drops_differ = cell_.along == AlongDrop::offset && rest_.size() == 2;
    Eigen::MatrixXd covariance(size.size(), size.size());
    for (Eigen::Index i = 0; i < size.size(); ++i)
      for (Eigen::Index j = 0; j < size.size(); ++j) {
        double in_sizes = i == j ? 1.0 : 0.0;
        if (cell_.along == AlongDrop::ar) in_sizes = std::pow(cell_.along_size, std::abs(i - j));
        if (drops_differ) in_sizes += cell_.along_size * cell_.along_size;
        const bool is_outlier = table_.is_outlier[drop][static_cast<std::size_t>(i) + 1];
        if (i == j && is_outlier) in_sizes += kOutlierDistance * kOutlierDistance;
        covariance(i, j) = size[i] * size[j] * in_sizes;
      }
    return covariance;
  }

  const Cell& cell_;
  const DrawnTable& table_;
  const DrawnLaw& law_;
  const DrawnBall& ball_;
  Eigen::Index n_constants_ = 0;
  Eigen::VectorXd more_;  ///< constants against the true ones
  Eigen::VectorXd rest_;
  Eigen::LLT<Eigen::MatrixXd> information_;
};

}  // namespace

std::vector<OracleEstimate> oracle_estimates(const Cell& cell, const DrawnTable& table,
                                             const std::vector<double>& speeds_mps) {
  const Oracle oracle(cell, table);
  std::vector<OracleEstimate> estimates;
  for (const double v_mps : speeds_mps) estimates.push_back(oracle.at(v_mps));
  return estimates;
}

}  // namespace bouncelab::testing
