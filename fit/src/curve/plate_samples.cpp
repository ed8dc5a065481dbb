// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/plate_samples.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kLongestPiece = 128;

/// d eps / d t of the onsets before, at and after an impact [1/s], eps the ratio of the intervals; and the variance of
/// each. Of heights d eps / d h of those before and after it [1/m], in the place of the last two.
struct OfOnsets {
  std::array<double, 3> by_time{};
  double sigma_t2 = 0.0;   ///< of one onset, if all three are known alike [s^2]
  double by_height = 0.0;  ///< error of eps by that of the height of a drop, which is no onset's
};
OfOnsets of_onsets(const RestitutionSample& s, double gravity_mps2) {
  OfOnsets of;
  const double before_s = 2.0 * s.v_mps / gravity_mps2;
  const double fallen_m = 0.5 * s.v_mps * s.v_mps / gravity_mps2, risen_m = fallen_m * s.eps * s.eps;
  if (s.conditions.of_heights)
    of.by_time = {0.0, -0.5 * s.eps / fallen_m, 0.5 * s.eps / risen_m};
  else if (s.impact == 0)  // of a drop from a known height
    of.by_time = {0.0, -1.0 / before_s, 1.0 / before_s}, of.by_height = s.eps * s.sigma_v_mps.value_or(0.0) / s.v_mps;
  else
    of.by_time = {s.eps / before_s, -(1.0 + s.eps) / before_s, 1.0 / before_s};
  double squares = 0.0;
  for (const double a : of.by_time) squares += a * a;
  of.sigma_t2 = std::max(0.0, square(s.sigma_eps.value_or(0.0)) - square(of.by_height)) / squares;
  return of;
}

/// Rows of one drop by their impacts, and the variances of the onsets that they are made of.
struct Drop {
  std::vector<std::size_t> rows;
  std::map<std::int64_t, std::pair<double, double>> onsets;  ///< sum of sigma_t^2, number of samples
};

/// v and eps of a drop's rows by a smooth train: ln T quadratic in the number of the impact, by least squares of T,
/// which has normal errors where ln T has not. About it eps is linear in large errors of the times, which then cancel
/// from row to row as they do in the sum of intervals.
void smooth(RestitutionSamples& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  constexpr Eigen::Index kEnoughToBend = 5;
  const Eigen::Index n_powers = n >= kEnoughToBend ? 3 : 2;
  Eigen::MatrixXd powers(n + 1, n_powers);
  Eigen::VectorXd v_mps(n + 1), of;
  const auto power_row = [&](double k) { return Eigen::RowVector3d(1.0, k, k * k).head(n_powers).eval(); };
  for (Eigen::Index k = 0; k <= n; ++k) {
    const RestitutionSample& s = rows[static_cast<std::size_t>(std::min(k, n - 1))];
    v_mps[k] = k < n ? s.v_mps : s.v_mps * std::max(s.eps, 0.05);
    powers.row(k) = power_row(static_cast<double>(s.impact - rows.front().impact + (k < n ? 0 : 1)));
  }
  constexpr int kTurns = 6;  // of Gauss and Newton, from the measured ones
  Eigen::VectorXd train = v_mps;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Eigen::VectorXd off = v_mps - train, ln_train = train.array().log();
    of = least_squares(train.asDiagonal() * powers, train.cwiseProduct(ln_train) + off);
    const double most_mps = v_mps.maxCoeff();
    train = (powers * of).array().exp().max(0.01 * most_mps).min(3.0 * most_mps);  // wherever a turn may lead
  }
  for (RestitutionSample& s : rows) {
    const auto at = [&](std::int64_t impact) {
      return power_row(static_cast<double>(impact - rows.front().impact)).dot(of);
    };
    const double first = at(s.impact), next = at(s.impact + 1);
    s.v_mps = exp(first);
    s.eps = std::clamp(exp(next - first), 0.1, 1.2);
  }
}

/// eps of each sample without its own scatter: between medians of those about as fast, straight in v.
std::vector<double> eps_of_as_fast(const RestitutionSamples& samples) {
  constexpr std::size_t kFewestOfMedian = 3, kMostMedians = 24;
  const std::size_t n = samples.size(), n_medians = std::clamp<std::size_t>(n / kFewestOfMedian, 1, kMostMedians);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return samples[a].v_mps < samples[b].v_mps; });
  TableLaw medians;
  for (std::size_t k = 0; k < n_medians; ++k) {
    const std::size_t begin = k * n / n_medians, end = (k + 1) * n / n_medians;
    const double v_mps = samples[order[(begin + end) / 2]].v_mps;
    if (!medians.v_mps.empty() && !(v_mps > medians.v_mps.back())) continue;
    std::vector<double> eps;
    for (std::size_t j = begin; j < end; ++j) eps.push_back(samples[order[j]].eps);
    medians.v_mps.push_back(v_mps);
    medians.eps.push_back(median(std::move(eps)));
  }
  if (const std::size_t last = medians.v_mps.size() - 1; last > 0) {  // straight on to the slowest and the fastest
    const auto beyond = [&](std::size_t from, std::size_t to, double v_mps) {
      const double slope = (medians.eps[to] - medians.eps[from]) / (medians.v_mps[to] - medians.v_mps[from]);
      return std::pair(v_mps, medians.eps[to] + slope * (v_mps - medians.v_mps[to]));
    };
    const auto slowest = beyond(1, 0, samples[order.front()].v_mps),
               fastest = beyond(last - 1, last, samples[order.back()].v_mps);
    if (slowest.first < medians.v_mps.front()) {
      medians.v_mps.insert(medians.v_mps.begin(), slowest.first);
      medians.eps.insert(medians.eps.begin(), slowest.second);
    }
    if (fastest.first > medians.v_mps.back())
      medians.v_mps.push_back(fastest.first), medians.eps.push_back(fastest.second);
  }
  std::vector<double> typical;
  for (const RestitutionSample& s : samples) typical.push_back(restitution(medians, s.v_mps));
  return typical;
}

}  // namespace

PlateSamples plate_samples(const RestitutionSamples& samples, const AirAndContact& known, Deviation at) {
  std::vector<Drop> drops;
  std::map<std::pair<std::string, std::int64_t>, std::size_t> number_of;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const RestitutionSample& s = samples[k];
    const auto [found, is_new] = number_of.try_emplace({s.recording, s.drop}, drops.size());
    if (is_new) drops.emplace_back();
    Drop& drop = drops[found->second];
    drop.rows.push_back(k);
    const OfOnsets of = of_onsets(s, known.gravity_mps2);
    for (int j = -1; j <= 1; ++j) {
      auto& [sum, n] = drop.onsets[s.impact + j];
      sum += of.sigma_t2, n += 1.0;
    }
  }
  PlateSamples all;
  all.n_drops = drops.size();
  const auto n = static_cast<Eigen::Index>(samples.size());
  const Eigen::Index n_open = (known.has_drag ? 1 : 0) + (known.has_contact ? 1 : 0);
  all.x.resize(n), all.eps.resize(n), all.impact.resize(n);
  all.dx.resize(n, n_open), all.deps.resize(n, n_open);
  all.timing = Eigen::MatrixXd::Zero(n, 3);
  all.excess = Eigen::VectorXd::Zero(n);
  all.timing_is_least = n > 0 && samples.front().conditions.sigma_is_least;
  all.ln_jacobian.resize(n);
  constexpr double kStep = 0.02;  // in ln: derivatives of a smooth transformation
  const OneAirAndContact here(known, at);
  std::vector<std::pair<OneAirAndContact, OneAirAndContact>> beside;
  const auto add_beside = [&](Deviation step) {
    beside.emplace_back(OneAirAndContact(known, {at.ln_kappa + step.ln_kappa, at.ln_tau + step.ln_tau}),
                        OneAirAndContact(known, {at.ln_kappa - step.ln_kappa, at.ln_tau - step.ln_tau}));
  };
  if (known.has_drag) add_beside({kStep, 0.0});
  if (known.has_contact) add_beside({0.0, kStep});
  const std::vector<double> typical =
      n_open > 0 && n > 0 ? eps_of_as_fast(samples) : std::vector<double>(samples.size());
  Eigen::Index row = 0;
  for (Drop& drop : drops) {
    std::stable_sort(drop.rows.begin(), drop.rows.end(),
                     [&](std::size_t a, std::size_t b) { return samples[a].impact < samples[b].impact; });
    RestitutionSamples measured, train;
    for (const std::size_t k : drop.rows) measured.push_back(samples[k]);
    train = measured;
    const bool is_train = all.timing_is_least && samples.front().conditions.of_flights();
    if (is_train) smooth(train);
    for (std::size_t k = 0; k < train.size() && is_train; ++k) {
      measured[k].eps = train[k].eps + (measured[k].eps - train[k].eps) * measured[k].v_mps / train[k].v_mps;
      measured[k].v_mps = train[k].v_mps;
    }
    std::vector<std::array<double, 3>> by_time;  // of the rows of this drop, times the standard error of each onset
    for (std::size_t k = 0; k < drop.rows.size(); ++k, ++row) {
      const RestitutionSample &s = measured[k], &in_train = train[k];
      const bool from_height = s.impact == 0;
      const auto moved = [&](const OneAirAndContact& one, double eps) {
        return known.is_open() ? one.at_the_plate(s.v_mps, eps, from_height) : AtThePlate{s.v_mps, eps, 1.0};
      };
      const AtThePlate plate = moved(here, s.eps);
      all.x[row] = log(plate.v_mps);
      all.impact[row] = static_cast<double>(s.impact);
      all.ln_jacobian[row] = log(plate.stretch);
      // the derivatives of a sample without its scatter: else a deviation would stretch or shrink the scatter in
      // proportion, beyond all bounds, and of thousands of samples what shrinks it most would be likeliest
      const double typical_eps = is_train ? in_train.eps : typical[drop.rows[k]];
      for (std::size_t j = 0; j < beside.size(); ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        const AtThePlate up = moved(beside[j].first, typical_eps), down = moved(beside[j].second, typical_eps);
        all.dx(row, column) = log(up.v_mps / down.v_mps) / (2.0 * kStep);
        all.deps(row, column) = (up.eps - down.eps) / (2.0 * kStep);
      }
      OfOnsets of = of_onsets(samples[drop.rows[k]], known.gravity_mps2);
      of.by_time = of_onsets(in_train, known.gravity_mps2).by_time;
      const bool of_times = s.conditions.of_flights();
      all.eps[row] = plate.eps;
      // to second order: a ratio of two noisy intervals, or a root of one of heights, is too large on average
      if (all.timing_is_least)
        all.excess[row] = 0.0;
      else if (s.conditions.of_heights)
        all.excess[row] = of.sigma_t2 * (1.5 * square(of.by_time[1]) - 0.5 * square(of.by_time[2])) / plate.eps;
      else if (of_times && !from_height)
        all.excess[row] = of.sigma_t2 * square(of.by_time[2]) * (1.0 + 2.0 * plate.eps);
      by_time.push_back(of.by_time);
      if (!of_times) {  // measured as it is, and rounded: with an error of its own
        by_time.back() = {};
        all.timing(row, 0) = square(plate.stretch * s.sigma_eps.value_or(0.0));
      }
      for (std::int64_t j = 0; j < 3; ++j) {
        const auto& [sum, n_samples] = drop.onsets[s.impact + j - 1];
        by_time.back()[static_cast<std::size_t>(j)] *= plate.stretch * std::sqrt(sum / n_samples);
      }
      for (const double a : by_time.back()) all.timing(row, 0) += a * a;
      all.timing(row, 0) += square(plate.stretch * of.by_height);
      for (std::size_t back = 1; back <= 2 && back <= k; ++back) {
        const std::int64_t lag = s.impact - samples[drop.rows[k - back]].impact;
        const std::array<double, 3>& other = by_time[k - back];
        double covariance = 0.0;
        for (std::int64_t j = 0; lag > 0 && j + lag < 3; ++j)
          covariance += by_time.back()[static_cast<std::size_t>(j)] * other[static_cast<std::size_t>(j + lag)];
        all.timing(row - static_cast<Eigen::Index>(back), static_cast<Eigen::Index>(back)) = covariance;
      }
      if (k % kLongestPiece == 0) all.pieces.push_back({row, 0});
      ++all.pieces.back().n;
    }
  }
  return all;
}

std::vector<Eigen::Index> rows_of_some(const PlateSamples& samples, Eigen::Index most) {
  const std::size_t stride =
      std::max<std::size_t>(1, static_cast<std::size_t>((samples.size() + most - 1) / std::max<Eigen::Index>(1, most)));
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < samples.pieces.size(); k += stride)
    for (Eigen::Index i = 0; i < samples.pieces[k].n; ++i) rows.push_back(samples.pieces[k].begin + i);
  return rows;
}

PlateSamples part_of(const PlateSamples& samples, const std::vector<Eigen::Index>& rows) {
  PlateSamples part = samples;
  part.x = samples.x(rows), part.eps = samples.eps(rows), part.excess = samples.excess(rows),
  part.impact = samples.impact(rows);
  part.dx = samples.dx(rows, Eigen::all), part.deps = samples.deps(rows, Eigen::all);
  part.timing = samples.timing(rows, Eigen::all);
  part.ln_jacobian = samples.ln_jacobian(rows);
  part.pieces.clear();
  Eigen::Index row = 0;
  for (const PlateSamples::Piece& piece : samples.pieces)
    if (row < part.size() && rows[static_cast<std::size_t>(row)] == piece.begin) {
      part.pieces.push_back({row, piece.n});
      row += piece.n;
    }
  return part;
}

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
// NOLINTNEXTLINE(performance-unnecessary-value-param): columns are written to
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
  Gram sum{Eigen::MatrixXd::Zero(n_columns, n_columns), 0.0, timing2, samples.ln_jacobian.sum()};
  for (const Gram& part : parts) sum.of += part.of, sum.ln_det += part.ln_det;
  sum.of.triangularView<Eigen::StrictlyUpper>() = sum.of.transpose();
  return sum;
}

std::vector<double> met_in_steps(const std::vector<double>& weights, double n) {
  double passed = 0.0, next = 0.5 / n;
  std::vector<double> times;
  for (const double weight : weights) {
    passed += weight;
    times.push_back(0.0);
    for (; next < passed; next += 1.0 / n) times.back() += 1.0;
  }
  return times;
}

double ln_prior_of_s(double ln_s) { return -0.5 * square((ln_s - kLnSMiddle) / kLnSSd); }

LikelyNoise with_likely_s(Noise noise, double step, std::size_t n,
                          const std::function<double(const Noise&)>& evidence) {
  constexpr double kLeast = -11.5, kMost = 1.0;  // of ln s: below 1e-5 sums of squares are lost in rounding
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
  double middle = std::max(noise.ln_s, kLeast);
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
  constexpr std::size_t kMany = 64;
  constexpr double kMet = 32.0;
  if (all.size() <= kMany) return all;
  std::vector<double> weights;
  double total = 0.0;
  for (const LikelyNoise& one : all) total += one.ln_s_sd * exp(one.ln_evidence - best);
  for (const LikelyNoise& one : all) weights.push_back(one.ln_s_sd * exp(one.ln_evidence - best) / total);
  const std::vector<double> times = met_in_steps(weights, kMet);
  std::vector<LikelyNoise> met;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (times[k] == 0.0) continue;
    met.push_back(all[k]);
    met.back().noise.ln_prior += log(times[k] / (weights[k] * kMet));
  }
  return met;
}

}  // namespace bouncelab::fit
