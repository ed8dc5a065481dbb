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
SpeedAndEps sample_at_plate(const DrawnBall& ball, double before_s, double after_s, double kappa_factor,
                            double tau_factor) {
  const FlightTable& flights = flights_of(ball);
  const auto tau_s = [&](double v) { return tau_factor * ball.tau_1_s * std::pow(v, ball.tau_exponent); };
  // the impact before came down by 1/eps faster than it went up; contacts hardly depend on it
  const double v_before_mps = 0.5 * kDrawnGravity_mps2 * before_s / std::clamp(after_s / before_s, 0.2, 1.0);
  const double up_mps = flights.launch_mps(before_s - tau_s(v_before_mps), kappa_factor);
  const double v_mps = flights.at(up_mps, kappa_factor).landing_mps;
  return {v_mps, flights.launch_mps(after_s - tau_s(v_mps), kappa_factor) / v_mps};
}

/// The law's constants, ln kappa, ln tau and, of one drop with a loss of its own, that: what is sought, of which the
/// truth and what is known beforehand are known.
class Oracle {
 public:
  Oracle(const Cell& cell, const DrawnTable& table)
      : cell_(cell), table_(table), law_(cell.its_law()), ball_(cell.its_ball()) {
    n_constants_ = static_cast<Eigen::Index>(law_.constants.size());
    has_own_ = cell.n_drops == 1 && cell.along == AlongDrop::offset;
    const Eigen::Index n = n_constants_ + 2 + (has_own_ ? 1 : 0);
    information_ = Eigen::MatrixXd::Zero(n, n);
    score_ = Eigen::VectorXd::Zero(n);
    add_prior(n_constants_, std::log(table.kappa_factor), kKappaSpread);
    add_prior(n_constants_ + 1, std::log(table.tau_factor), ball_.tau_spread);
    if (has_own_) add_prior(n_constants_ + 2, table.offsets[0], cell.along_size);
    for (auto first = table.onsets.begin(); first != table.onsets.end();) {
      const auto last = std::find_if(first, table.onsets.end(), [&](const Onset& o) { return o.drop != first->drop; });
      if (last - first >= 3) add_drop({first, last});
      first = last;
    }
    root_.compute(information_);
  }

  OracleEstimate at(double v_mps) const {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(score_.size());
    row.head(n_constants_) = by_constants(v_mps);
    if (has_own_) row[n_constants_ + 2] = cell_.scatter_at(v_mps);
    const Eigen::VectorXd solved = root_.solve(row);
    return {mean_eps(cell_, table_, v_mps) + solved.dot(score_), std::sqrt(solved.dot(row))};
  }

 private:
  /// Known beforehand to be 0 within sd; truly `true_value`, about which everything is linear.
  void add_prior(Eigen::Index i, double true_value, double sd) {
    information_(i, i) += 1.0 / (sd * sd);
    score_[i] -= true_value / (sd * sd);
  }

  /// d eps / d constants.
  Eigen::VectorXd by_constants(double v_mps) const {
    Eigen::VectorXd row(n_constants_);
    for (Eigen::Index i = 0; i < n_constants_; ++i) {
      std::vector<double> up = law_.constants, down = up;
      const auto j = static_cast<std::size_t>(i);
      constexpr double kStep = 1e-5;
      up[j] += kStep;
      down[j] -= kStep;
      row[i] = (law_.eps(v_mps, up) - law_.eps(v_mps, down)) / (2.0 * kStep);
    }
    return row;
  }

  /// Residual's change, (b - a) of two treatments of the same sample. The law's slope is taken at a point, so that no
  /// sample beside a step has one of its own.
  double change(SpeedAndEps a, SpeedAndEps b, double v_mps) const {
    const double h_mps = 1e-6 * v_mps;
    const double slope =
        (law_.eps(v_mps + h_mps, law_.constants) - law_.eps(v_mps - h_mps, law_.constants)) / (2.0 * h_mps);
    return b.eps - a.eps - slope * (b.v_mps - a.v_mps);
  }

  void add_drop(std::span<const Onset> onsets) {
    const auto n = static_cast<Eigen::Index>(onsets.size()) - 2;
    const auto drop = static_cast<std::size_t>(onsets[0].drop);
    Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, score_.size());
    Eigen::MatrixXd by_time = Eigen::MatrixXd::Zero(n, n + 2), covariance(n, n);
    Eigen::VectorXd residual(n), size(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i) + 1;
      const double before_s = onsets[k].t_s - onsets[k - 1].t_s, after_s = onsets[k + 1].t_s - onsets[k].t_s;
      const auto treated = [&](double ln_kappa, double ln_tau, double more_before_s, double more_after_s) {
        return sample_at_plate(ball_, before_s + more_before_s, after_s + more_after_s,
                               table_.kappa_factor * std::exp(ln_kappa), table_.tau_factor * std::exp(ln_tau));
      };
      const SpeedAndEps here = treated(0, 0, 0, 0);
      const double own = has_own_ ? table_.offsets[0] * cell_.scatter_at(here.v_mps) : 0.0;
      // a ratio of two noisy intervals is too large on average, to second order
      const double too_large = (1.0 + 2.0 * here.eps) * std::pow(cell_.sigma_t_s / before_s, 2.0);
      residual[i] = here.eps - too_large - law_.eps(here.v_mps, law_.constants) - own;
      constexpr double kLn = 0.01, kTime_s = 1e-6;
      design.row(i).head(n_constants_) = by_constants(here.v_mps).transpose();
      design(i, n_constants_) = -change(treated(-kLn, 0, 0, 0), treated(kLn, 0, 0, 0), here.v_mps) / (2.0 * kLn);
      design(i, n_constants_ + 1) = -change(treated(0, -kLn, 0, 0), treated(0, kLn, 0, 0), here.v_mps) / (2.0 * kLn);
      if (has_own_) design(i, n_constants_ + 2) = cell_.scatter_at(here.v_mps);
      const double by_before =
          change(treated(0, 0, -kTime_s, 0), treated(0, 0, kTime_s, 0), here.v_mps) / (2.0 * kTime_s);
      const double by_after =
          change(treated(0, 0, 0, -kTime_s), treated(0, 0, 0, kTime_s), here.v_mps) / (2.0 * kTime_s);
      by_time(i, i) = -by_before;
      by_time(i, i + 1) = by_before - by_after;
      by_time(i, i + 2) = by_after;
      size[i] = cell_.scatter_at(here.v_mps);
    }
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        double correlation = i == j ? 1.0 : 0.0;
        if (cell_.along == AlongDrop::ar) correlation = std::pow(cell_.along_size, std::abs(i - j));
        if (cell_.along == AlongDrop::offset && !has_own_) correlation += cell_.along_size * cell_.along_size;
        if (i == j && table_.is_outlier[drop][static_cast<std::size_t>(i) + 1])
          correlation += kOutlierDistance * kOutlierDistance;
        covariance(i, j) = size[i] * size[j] * correlation;
      }
    covariance += cell_.sigma_t_s * cell_.sigma_t_s * by_time * by_time.transpose();
    const Eigen::LLT<Eigen::MatrixXd> root(covariance);
    information_ += design.transpose() * root.solve(design);
    score_ += design.transpose() * root.solve(residual);
  }

  const Cell& cell_;
  const DrawnTable& table_;
  const DrawnLaw& law_;
  const DrawnBall& ball_;
  Eigen::Index n_constants_ = 0;
  bool has_own_ = false;
  Eigen::MatrixXd information_;
  Eigen::VectorXd score_;
  Eigen::LLT<Eigen::MatrixXd> root_;
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
