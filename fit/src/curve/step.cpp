// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "curve/curve_sum.hpp"

namespace bouncelab::fit {

/// A step is one more column, 1 above its speed, with a size beforehand of some part of 1 - eps. It is stated where it
/// is nearly certain that one is there, at whichever speed, beside a curve that may bend.
void SmoothCurve::describe_step(const Sum& sum, const RestitutionSamples& samples) {
  const CurveAt& curve = places_.front();
  const CurveAt::Part& some = curve.some();
  constexpr double kOfLost = 0.6;                        // a floor beside another loses some half as much or twice
  constexpr std::size_t kBeside = 4, kMostPlaces = 200;  // samples on either side: fewer may be impacts that were lost
  const double nearly_certain = log(99.0);
  std::vector<double> x(some.samples.x.data(), some.samples.x.data() + some.samples.size()), at_x;
  std::sort(x.begin(), x.end());
  for (std::size_t k = kBeside; k + kBeside <= x.size(); k += 1 + x.size() / kMostPlaces)
    at_x.push_back(0.5 * (x[k - 1] + x[k]));
  if (at_x.empty()) return;
  const auto n_places = static_cast<Eigen::Index>(at_x.size()), n_before = some.columns.cols();
  Eigen::MatrixXd columns(some.samples.size(), n_before + n_places);
  columns.leftCols(n_before) = some.columns;
  for (Eigen::Index k = 0; k < n_places; ++k)
    columns.col(n_before + k) = (some.samples.x.array() > at_x[static_cast<std::size_t>(k)]).cast<double>();
  const Term& best = sum.best;
  const Gram with_steps = gram_of(some.samples, curve.x_middle(), some.inflation, columns, sum.noises[best.noise]);
  const Gram without{with_steps.of.topLeftCorner(n_before, n_before), with_steps.ln_det, with_steps.timing2,
                     with_steps.ln_jacobian};
  const LinearEquations of = curve.linear(without, best.base);
  const std::vector<Eigen::Index> unknowns = curve.unknowns_of(best.base);
  const Eigen::MatrixXd of_steps = with_steps.of(unknowns, Eigen::seqN(n_before, n_places));
  const Eigen::Index residual = curve.residual_of(best.base);
  struct Step {
    double ln_evidence = 0.0, mean = 0.0, variance = 0.0, slower = 0.0;
  };
  std::vector<double> ln_evidence;
  std::vector<std::vector<Step>> steps(at_x.size());
  for (const Slopes::Place& place : Slopes::places()) {
    const Solution solution = curve.solve(of, place);
    ln_evidence.push_back(solution.ln_evidence);
    const Eigen::MatrixXd half = solution.root.matrixL().solve(of_steps);
    for (Eigen::Index k = 0; k < n_places; ++k) {
      const Eigen::Index column = n_before + k;
      const double prior2 = square(kOfLost * curve.lost());
      const double precision = with_steps.of(column, column) - half.col(k).squaredNorm() + 1.0 / prior2;
      const double right = with_steps.of(column, residual) -
                           with_steps.timing2 * with_steps.of(column, curve.excess()) - half.col(k).dot(solution.half);
      Step step{solution.ln_evidence + 0.5 * square(right) / precision - 0.5 * log(precision * prior2) -
                    log(static_cast<double>(n_places)),
                right / precision, 1.0 / precision};
      const double x_here = at_x[static_cast<std::size_t>(k)];
      const Eigen::VectorXd rest =
          solution.root.matrixU().solve(Eigen::VectorXd(solution.half - step.mean * half.col(k)));
      const auto [eps, unit] = curve.base_at(best.base, x_here);
      step.slower = eps + unit * rest[0] + curve.slopes().row(x_here).dot(rest.segment(1, curve.slopes().n_knots()));
      steps[static_cast<std::size_t>(k)].push_back(step);
    }
  }
  std::vector<double> ln_with;
  for (const std::vector<Step>& at_one : steps) {
    std::vector<double> ln;
    for (const Step& step : at_one) ln.push_back(step.ln_evidence);
    ln_with.push_back(ln_sum(ln));
  }
  if (ln_sum(ln_with) - ln_sum(ln_evidence) < nearly_certain) return;
  const auto likeliest = static_cast<std::size_t>(std::max_element(ln_with.begin(), ln_with.end()) - ln_with.begin());
  double mean = 0.0, squares = 0.0, slower = 0.0;
  for (const Step& step : steps[likeliest]) {
    const double weight = exp(step.ln_evidence - ln_with[likeliest]);
    mean += weight * step.mean, squares += weight * (step.variance + square(step.mean)), slower += weight * step.slower;
  }
  curve_.step = RestitutionStep{exp(at_x[likeliest]), slower + mean, slower,
                                normal_estimate(mean, std::sqrt(squares - square(mean))), std::nullopt};
  if (curve.all().samples.n_drops > 1) return;
  for (const RestitutionSample& s : at_the_plate(samples, known(), deviation_))
    if (s.v_mps > curve_.step->v_mps) curve_.step->impact = std::max(curve_.step->impact.value_or(s.impact), s.impact);
}

}  // namespace bouncelab::fit
