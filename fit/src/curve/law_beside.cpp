// SPDX-License-Identifier: GPL-3.0-or-later
// Does a law of few constants describe the samples, and what do drag and contact time leave open of it?
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "curve/smooth_curve.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kPlaces = 25;  // speeds at which the deviation is looked at

}  // namespace

LawBeside SmoothCurve::beside(const LawModel& law, const Eigen::VectorXd& q,
                              const std::optional<ScatterModel>& scatter) const {
  const CurveAt& curve = places_.front();
  const Eigen::Index n_open = curve.n_open();
  // columns of the law in place of the base's: law, from its peak to the mean, slopes, deviations; residual
  const auto columns_of = [&](const CurveAt::Part& part) {
    const PlateSamples& s = part.samples;
    std::vector<double> v_mps(s.x.data(), s.x.data() + s.size());
    exp_each(v_mps);
    Eigen::VectorXd to_mean = Eigen::VectorXd::Zero(s.size());
    if (scatter)
      for (Eigen::Index i = 0; i < s.size(); ++i)
        to_mean[i] = scatter->mean_minus_peak(v_mps[static_cast<std::size_t>(i)]);
    const auto n_bases = static_cast<Eigen::Index>(bases().size());
    Eigen::MatrixXd columns(s.size(), q.size() + 1 + curve.slopes().n_knots() + n_open + 1);
    columns << law.jacobian(v_mps, q), to_mean, part.columns.middleCols(n_bases, curve.slopes().n_knots() + n_open),
        s.eps - square(curve.timing()) * s.excess - law.eps(v_mps, q) - to_mean;
    return columns;
  };
  const Eigen::MatrixXd all = columns_of(curve.all()), some = curve.all().samples.size() == curve.some().samples.size()
                                                                  ? all
                                                                  : columns_of(curve.some());
  const Eigen::Index n_law = q.size() + 1, n = n_law + curve.slopes().n_knots() + n_open;
  std::vector<Eigen::Index> alone, with;
  for (Eigen::Index k = 0; k < n; ++k) {
    with.push_back(k);
    if (k < n_law || k >= n_law + curve.slopes().n_knots()) alone.push_back(k);
  }
  const auto equations = [&](const Gram& gram, const std::vector<Eigen::Index>& unknowns) {
    LinearEquations linear{gram.of(unknowns, unknowns), gram.of(unknowns, n), -0.5 * (gram.ln_det + gram.of(n, n))};
    constexpr double kFlat = 1e-2;  // of the law's values, alike in both
    linear.precision.diagonal().head(q.size()).array() += kFlat;
    // the density of the scatter is a model: from its peak to the mean may be a third more or less
    linear.precision(q.size(), q.size()) += 9.0;
    curve.add_prior_of_deviations(gram, linear, linear.precision.rows() - n_open);
    return linear;
  };
  const auto ln_alone = [&](const Gram& gram) {
    const LinearEquations of = equations(gram, alone);
    const Eigen::LLT<Eigen::MatrixXd> root(of.precision);
    return of.constant + 0.5 * Eigen::VectorXd(root.matrixL().solve(of.right)).squaredNorm() -
           root.matrixLLT().diagonal().array().log().sum();
  };
  const auto gram_by = [&](const CurveAt::Part& part, const Eigen::MatrixXd& columns, const Noise& noise) {
    return gram_of(part.samples, curve.x_middle(), part.inflation, columns, noise);
  };
  // with the deviation the scatter is that of the curve; alone the law scatters as it has to
  std::vector<double> ln_with;
  Solution best;
  best.ln_evidence = -HUGE_VAL;
  for (const LikelyNoise& likely : noises_) {
    const Gram gram = gram_by(curve.all(), all, likely.noise);
    const double prior = log(likely.ln_s_sd) + likely.noise.ln_prior + ln_prior_of_s(likely.noise.ln_s);
    const LinearEquations of = equations(gram, with);
    for (const Slopes::Place& place : Slopes::places()) {
      Solution one = curve.solve(of, place, n_law);
      ln_with.push_back(prior + one.ln_evidence);
      if (ln_with.back() > best.ln_evidence) best = std::move(one), best.ln_evidence = ln_with.back();
    }
  }
  const auto n_some = static_cast<std::size_t>(curve.some().samples.size());
  const auto evidence = [&](const Noise& noise) { return ln_alone(gram_by(curve.some(), some, noise)); };
  const LikelyNoise first = with_likely_s(noises_.front().noise, 0.5, n_some, evidence);
  std::vector<double> ln_of_law;
  for (LikelyNoise likely :
       likely_noises(first, {{curve.timing(), 1.0}}, curve.all().samples.n_drops, n_some, evidence)) {
    likely = curve.of_all(likely, [&](const Noise& noise) { return ln_alone(gram_by(curve.all(), all, noise)); });
    ln_of_law.push_back(log(likely.ln_s_sd) + likely.ln_evidence);
  }
  LawBeside beside;
  beside.misfit.ln_bayes_factor = ln_sum(ln_with) - ln_sum(ln_of_law);
  // where the deviation stands out most
  const Eigen::VectorXd unknowns = best.unknowns();
  double most = 0.0;
  for (std::size_t k = 0; k < kPlaces; ++k) {
    const double x = lo_ + (hi_ - lo_) * static_cast<double>(k) / (kPlaces - 1);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row.segment(n_law, curve.slopes().n_knots()) = curve.slopes().row(x).transpose();
    row.head(q.size()) = law.jacobian(std::vector{exp(x)}, q).row(0).transpose();
    const double off = row.dot(unknowns), sd = Eigen::VectorXd(best.root.matrixL().solve(row)).norm();
    if (std::abs(off) > most * sd) most = std::abs(off) / sd, beside.misfit.v_mps = exp(x), beside.misfit.off = off;
  }
  beside.covariance = Eigen::MatrixXd::Zero(q.size(), q.size());
  if (n_open == 0) return beside;  // Eigen's LDLT reads the first of no columns
  // least squares: what drag and contact time do to the law's values
  const Gram of_best = gram_by(curve.all(), all, noises_.front().noise);
  const Eigen::MatrixXd own = of_best.of.topLeftCorner(q.size(), q.size());
  const Eigen::MatrixXd by_deviation = -own.ldlt().solve(of_best.of.block(0, n - n_open, q.size(), n_open));
  beside.covariance = by_deviation * deviation_covariance_ * by_deviation.transpose();
  return beside;
}

}  // namespace bouncelab::fit
