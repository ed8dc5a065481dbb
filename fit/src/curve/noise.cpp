// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/noise.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::fit {
namespace {

// few balls do better than half a percent on any floor; with five samples or more the samples decide
constexpr double kLnSMiddle = -5.298317366548036, kLnSSd = 1.2;  // ln 0.005
// scatter by asperities goes as 1/v (docs/physics.md, 7), others hardly
constexpr double kPowers[] = {0.0, 0.5, 1.0}, kShareOfPower[] = {0.35, 0.4, 0.25};
constexpr double kShareWithoutShared = 0.3;  // of drops that share nothing
constexpr double kLikely = 4.0;              // in the logarithm: what is further behind the best is left out
constexpr std::size_t kPiecesAtOnce = 64;

/// Of the rows of one piece.
Eigen::MatrixXd covariance_of(const PlateSamples& samples, const PlateSamples::Piece& piece, const Eigen::VectorXd& own,
                              const Eigen::VectorXd& size, const Noise& noise) {
  const auto [begin, n] = piece;
  Eigen::MatrixXd covariance(n, n);
  const double rho2 = noise.rho * noise.rho, ln_phi = log(noise.phi), timing2 = noise.timing * noise.timing;
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i)
      covariance(i, j) =
          rho2 * size[i] * size[j] * exp(ln_phi * (samples.impact[begin + i] - samples.impact[begin + j]));
    covariance(j, j) += own[j];
    for (Eigen::Index lag = 0; lag <= 2 && j + lag < n; ++lag)
      covariance(j + lag, j) += timing2 * samples.timing(begin + j, lag);
  }
  return covariance;
}

/// A row a sample: neighbouring rows are taken off each other, and all rows of many pieces multiplied at once.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// L^-1 columns, C = L L^T. @return ln det C
double whiten(Eigen::MatrixXd covariance, Eigen::Ref<Rows> columns) {
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> root(covariance);
  root.matrixL().solveInPlace(columns);
  return 2.0 * covariance.diagonal().array().log().sum();
}

/// The same where only neighbouring rows share anything, by their times. @param own  variance of each row's own
double whiten_by_timing(const Eigen::Ref<const Eigen::MatrixXd>& timing, const Eigen::VectorXd& own,
                        Eigen::Ref<Rows> columns) {
  double ln_det = 0.0, last = 1.0, last_of_one = 0.0, before_last = 1.0;
  for (Eigen::Index i = 0; i < own.size(); ++i) {
    const double of_two = i > 1 ? timing(i - 2, 2) / before_last : 0.0;
    const double of_one = i > 0 ? (timing(i - 1, 1) - of_two * last_of_one) / last : 0.0;
    const double root = std::sqrt(own[i] + timing(i, 0) - of_one * of_one - of_two * of_two);
    if (of_one != 0.0) columns.row(i) -= of_one * columns.row(i - 1);
    if (of_two != 0.0) columns.row(i) -= of_two * columns.row(i - 2);
    columns.row(i) /= root;
    ln_det += 2.0 * log(root);
    before_last = last, last = root, last_of_one = of_one;
  }
  return ln_det;
}

}  // namespace

double Noise::variance(double ln_ratio) const { return exp(2.0 * ln_s - 2.0 * power * ln_ratio) * (1.0 + rho * rho); }

Gram gram_of(const PlateSamples& samples, double x_middle, const Eigen::VectorXd& inflation,
             const Eigen::MatrixXd& columns, const Noise& noise) {
  const std::size_t n_parts = (samples.pieces.size() + kPiecesAtOnce - 1) / kPiecesAtOnce;
  const Eigen::Index n_columns = columns.cols();
  const double timing2 = noise.timing * noise.timing;
  std::vector<Gram> parts(n_parts);
  parallel_for(n_parts, 0, [&](std::size_t part) {
    Gram& gram = parts[part];
    const std::size_t first = part * kPiecesAtOnce, end = std::min(samples.pieces.size(), first + kPiecesAtOnce);
    const Eigen::Index first_row = samples.pieces[first].begin;
    const Eigen::Index n_rows = samples.pieces[end - 1].begin + samples.pieces[end - 1].n - first_row;
    Eigen::VectorXd size = noise.ln_s - noise.power * (samples.x.segment(first_row, n_rows).array() - x_middle);
    exp_each({size.data(), static_cast<std::size_t>(n_rows)});
    const Eigen::VectorXd own = size.cwiseAbs2().cwiseProduct(inflation.segment(first_row, n_rows));
    Rows white(n_rows, n_columns + 1);
    white << columns.middleRows(first_row, n_rows), noise.rho * size;
    Eigen::MatrixXd shared(n_columns, static_cast<Eigen::Index>(end - first));  // by pieces whose rows share a loss
    Eigen::Index n_shared = 0;
    for (std::size_t k = first; k < end; ++k) {
      const auto [begin, n] = samples.pieces[k];
      const auto segment = [begin = begin - first_row, n = n](const Eigen::VectorXd& of) {
        return of.segment(begin, n);
      };
      auto rows = white.middleRows(begin - first_row, n);
      if (noise.rho > 0.0 && noise.phi < 1.0) {
        gram.ln_det += whiten(covariance_of(samples, samples.pieces[k], segment(own), segment(size), noise), rows);
        continue;
      }
      gram.ln_det += whiten_by_timing(timing2 * samples.timing.middleRows(begin, n), segment(own), rows);
      if (!(noise.rho > 0.0)) continue;
      const double more = 1.0 + rows.col(n_columns).squaredNorm();  // C + b b^T
      gram.ln_det += log(more);
      shared.col(n_shared++) = rows.leftCols(n_columns).transpose() * rows.col(n_columns) / std::sqrt(more);
    }
    gram.of = Eigen::MatrixXd::Zero(n_columns, n_columns);
    gram.of.selfadjointView<Eigen::Lower>().rankUpdate(white.leftCols(n_columns).transpose());
    if (n_shared > 0)  // Eigen divides by the number of columns
      gram.of.selfadjointView<Eigen::Lower>().rankUpdate(shared.leftCols(n_shared), -1.0);
  });
  Gram sum{Eigen::MatrixXd::Zero(n_columns, n_columns), 0.0, timing2, samples.ln_jacobian.sum(),
           samples.ln_jacobian_slopes.colwise().sum().transpose()};
  for (const Gram& part : parts) sum.of += part.of, sum.ln_det += part.ln_det;
  sum.of.triangularView<Eigen::StrictlyUpper>() = sum.of.transpose();
  return sum;
}

double ln_prior_of_s(double ln_s) { return -0.5 * square((ln_s - kLnSMiddle) / kLnSSd); }

LikelyNoise with_likely_s(Noise noise, double step, std::size_t n,
                          const std::function<double(const Noise&)>& evidence) {
  constexpr double kLeast = -16.0, kMost = 1.0;  // of ln s
  std::map<double, double> known;
  const auto at = [&](double ln_s) {
    const auto [found, is_new] = known.try_emplace(ln_s, 0.0);
    if (is_new) {
      Noise one = noise;
      one.ln_s = ln_s;
      found->second = evidence(one) + noise.ln_prior + ln_prior_of_s(ln_s);
    }
    return found->second;
  };
  double middle = noise.ln_s;
  const double width = 1.0 / std::sqrt(2.0 * static_cast<double>(n) + 2.0);
  for (;; step *= 0.5) {
    while (at(middle - step) > at(middle) && middle - step > kLeast) middle -= step;
    while (at(middle + step) > at(middle) && middle + step < kMost) middle += step;
    if (step < 1.2 * width) break;
  }
  const double below = at(middle - step), here = at(middle), above = at(middle + step);
  constexpr double kLeastCurvature = 0.5;
  const double curvature = std::max((2.0 * here - below - above) / square(step), kLeastCurvature);
  const double shift = std::clamp((above - below) / (2.0 * step * curvature), -step, step);
  noise.ln_s = middle + shift;
  return {noise, std::min(1.0, 1.0 / std::sqrt(curvature)), here + 0.5 * curvature * square(shift)};
}

std::vector<LikelyNoise> likely_noises(const LikelyNoise& first, const std::vector<std::pair<double, double>>& timings,
                                       std::size_t n_drops, std::size_t n,
                                       const std::function<double(const Noise&)>& evidence) {
  std::vector<LikelyNoise> all;
  double best = -HUGE_VAL;
  const auto consider = [&](double timing, double rho, double phi, double share) {
    double best_here = -HUGE_VAL;
    for (std::size_t i = 0; i < std::size(kPowers); ++i) {
      Noise noise{0.0, kPowers[i], rho, phi, log(share * kShareOfPower[i]), timing};
      noise.ln_s = first.noise.ln_s - 0.5 * log(1.0 + rho * rho);
      // where more is shared less is left to single bounces: as much as the smaller share left
      for (const LikelyNoise& known : all)
        if (known.noise.power == noise.power && known.noise.timing == timing &&
            (rho == 0.0 || (known.noise.phi == phi && known.noise.rho > 0.0)))
          noise.ln_s = known.noise.ln_s;
      const LikelyNoise likely = with_likely_s(noise, 0.25, n, evidence);
      all.push_back(likely);
      best_here = std::max(best_here, likely.ln_evidence);
    }
    best = std::max(best, best_here);
    return best_here;
  };
  const double without = n_drops > 1 ? kShareWithoutShared : 1.0;
  std::vector<std::pair<double, double>> likely = timings;
  for (auto& [timing, share] : likely)
    if (consider(timing, 0.0, 1.0, without * share) < best - kLikely) share = 0.0;
  // rho beforehand: half a Cauchy distribution of scale 1, at steps of a factor 2, for as long as more may be likely
  // (Gelman, Bayesian Analysis 1, 515 (2006), doi:10.1214/06-BA117A)
  for (const auto& [timing, share] : likely)
    for (const double phi : {1.0, 0.8})
      for (double rho = 0.35; n_drops > 1 && share > 0.0 && rho < 1e7; rho *= 2.0) {
        const double density = 2.0 / kPi * rho / (1.0 + rho * rho) * log(2.0);
        const double here = consider(timing, rho, phi, 0.5 * (1.0 - kShareWithoutShared) * density * share);
        if (rho > 2.0 && here < best - kLikely) break;
      }
  std::erase_if(all, [&](const LikelyNoise& one) { return one.ln_evidence < best - kLikely; });
  // of very many those that are met at equal steps through all of their weights
  constexpr std::size_t kMany = 64, kMet = 32;
  if (all.size() <= kMany) return all;
  const auto weight = [&](const LikelyNoise& one) { return one.ln_s_sd * exp(one.ln_evidence - best); };
  double total = 0.0, passed = 0.0, next = 0.5 / kMet;
  for (const LikelyNoise& one : all) total += weight(one);
  std::vector<LikelyNoise> met;
  for (const LikelyNoise& one : all) {
    passed += weight(one) / total;
    double times = 0.0;
    for (; next < passed; next += 1.0 / kMet) times += 1.0;
    if (times == 0.0) continue;
    met.push_back(one);
    met.back().noise.ln_prior += log(times * total / (weight(one) * kMet));
  }
  return met;
}

}  // namespace bouncelab::fit
