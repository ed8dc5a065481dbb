// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/template_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Dense>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"
#include "drops/drop_timer.hpp"
#include "template/subband_delay.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kRoundsOfSquares = 2, kRoundsOfShapes = 16;
constexpr double kLittleMove = 1e-3, kMostMove = 0.3;  // samples

/// W^2/|W| of every step-th bin: the same whatever the modes' signs.
audio::Spectrum squared(const audio::Spectrum& modes, std::size_t step) {
  audio::Spectrum squares;
  for (std::size_t k = 0; k < modes.size(); k += step) {
    const float re = modes.re[k], im = modes.im[k], scale = 1.0F / (std::sqrt(re * re + im * im) + 1e-30F);
    squares.re.push_back(scale * (re * re - im * im));
    squares.im.push_back(scale * 2.0F * re * im);
  }
  return squares;
}

struct Alignment {
  double later = 0.0;  // than the others [samples]
  bool is_alike = true;
};

/// Mean over the places where the modes of one agree with those of the others, each with its probability: by how well
/// they do, over the variance of what does not, and by Student's t with three degrees of freedom about no shift, since
/// the beginning that a template shows is right to about a radian of its frequencies; against even odds of no likeness.
/// Shifts of squares are twice those of the templates.
Alignment aligned_with(const MatchedFilter& others, const audio::Spectrum& squares, double reach) {
  if (!(others.energy() > 0.0)) return {};
  const std::vector<CorrelationPeak> peaks = Correlation(others, squares, -2.0 * reach, 2.0 * reach).peaks();
  const DelayEstimate best = estimate_delay(others, split_into_subbands(others), squares, peaks.front().shift);
  if (!(best.amplitude > 0.0)) return {0.0, false};
  audio::Spectrum rest = squares;
  audio::add_scaled(rest, audio::phase_shifted(others.spectrum(), -others.omega() * best.shift), -best.amplitude);
  const double disturbance = 0.5 * others.energy_times_power_of(rest) / others.energy() + 1e-30;
  const double radian = 1.0 / (2.0 * kPi * others.rms_frequency());
  const double sigma_of_peaks = std::sqrt(best.variance * disturbance) / radian;
  const double best_ratio = peaks.front().log_likelihood_ratio / disturbance;
  const double unlike = exp(-best_ratio) / sigma_of_peaks;
  double sum = 0.0, weights = 0.0;
  for (const CorrelationPeak& peak : peaks) {
    const double shift = peak.shift - peaks.front().shift + best.shift;
    const double weight =
        exp(peak.log_likelihood_ratio / disturbance - best_ratio) / square(1.0 + square(shift / radian) / 3.0);
    sum += weight * shift;
    weights += weight;
  }
  return {0.5 * sum / (weights + unlike), weights > unlike};
}

/// Right singular vectors of the largest singular values, as columns: by the smaller of the two products of the waves,
/// one a row.
Eigen::MatrixXd leading_shapes(const Eigen::MatrixXd& waves, Eigen::Index n_shapes) {
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
  if (waves.rows() >= waves.cols()) return Solver(waves.transpose() * waves).eigenvectors().rightCols(n_shapes);
  const Solver solver(waves * waves.transpose());
  const Eigen::MatrixXd scale =
      solver.eigenvalues().tail(n_shapes).cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal();
  return waves.transpose() * solver.eigenvectors().rightCols(n_shapes) * scale;
}

/// Gauss-Newton step of each template towards the shapes that they share. In a few bins only one or two modes sound:
/// the templates are sums of a few shapes there, with real factors. What these leave has the same variance in all of
/// the bins.
Eigen::VectorXd moves_towards_shapes(const std::vector<audio::Spectrum>& modes, std::size_t n_window) {
  const auto n = static_cast<Eigen::Index>(modes.size());
  const auto n_bins = kDrops.bins_of_shape;
  const auto n_shapes = std::min(kDrops.most_shapes, n / 2);
  const double omega = 2.0 * kPi / static_cast<double>(n_window);
  Eigen::VectorXd slopes = Eigen::VectorXd::Zero(n), information = Eigen::VectorXd::Constant(n, 1e-30);
  Eigen::MatrixXd waves(n, 2 * n_bins), changes(n, 2 * n_bins);
  for (Eigen::Index first = 1; first + n_bins <= std::ssize(modes.front().re); first += n_bins) {
    for (Eigen::Index d = 0; d < n; ++d)
      for (Eigen::Index j = 0; j < n_bins; ++j) {
        const auto k = static_cast<std::size_t>(first + j);
        const auto& [re, im] = modes[static_cast<std::size_t>(d)];
        waves(d, 2 * j) = re[k], waves(d, 2 * j + 1) = im[k];
        const double w = omega * static_cast<double>(k);
        changes(d, 2 * j) = -w * im[k], changes(d, 2 * j + 1) = w * re[k];
      }
    const Eigen::MatrixXd shapes = leading_shapes(waves, n_shapes);
    const Eigen::MatrixXd rest = waves - waves * shapes * shapes.transpose();
    changes -= changes * shapes * shapes.transpose();
    const double weight = 1.0 / (rest.squaredNorm() + 1e-12 * waves.squaredNorm() + 1e-30);
    slopes += weight * rest.cwiseProduct(changes).rowwise().sum();
    information += weight * changes.rowwise().squaredNorm();
  }
  return -slopes.cwiseQuotient(information).cwiseMax(-kMostMove).cwiseMin(kMostMove);
}

}  // namespace

std::vector<double> align_templates(std::vector<audio::Spectrum> modes, double reach) {
  std::vector<double> later(modes.size(), 0.0);
  if (modes.size() < 2) return later;
  std::size_t n_bins = modes.front().size();
  for (const audio::Spectrum& of : modes) n_bins = std::min(n_bins, of.size());
  const std::size_t n_window = 2 * (n_bins - 1);
  const double omega = 2.0 * kPi / static_cast<double>(n_window);
  std::vector<audio::Spectrum> squares;
  for (audio::Spectrum& of : modes) {
    const std::size_t step = (of.size() - 1) / (n_bins - 1);
    squares.push_back(squared(of, step));
    for (std::size_t k = 0; k < n_bins; ++k) of.re[k] = of.re[k * step], of.im[k] = of.im[k * step];
    of.re.resize(n_bins), of.im.resize(n_bins);
  }
  audio::Spectrum sum{std::vector<float>(n_bins, 0.0F), std::vector<float>(n_bins, 0.0F)};
  std::vector<Alignment> found(modes.size());
  const auto placed = [&](std::size_t d) { return audio::phase_shifted(squares[d], 2.0 * omega * found[d].later); };
  for (int round = 0; round < kRoundsOfSquares; ++round)
    for (std::size_t d = 0; d < modes.size(); ++d) {
      if (round > 0) audio::add_scaled(sum, placed(d), -1.0);
      found[d] = aligned_with(MatchedFilter(sum, n_window), squares[d], reach);
      audio::add_scaled(sum, placed(d), 1.0);
    }
  std::vector<audio::Spectrum> alike;
  for (std::size_t d = 0; d < modes.size(); ++d) {
    later[d] = found[d].later;
    if (found[d].is_alike) alike.push_back(audio::phase_shifted(modes[d], omega * later[d]));
  }
  for (int round = 0; round < kRoundsOfShapes && alike.size() > 1; ++round) {
    const Eigen::VectorXd moves = moves_towards_shapes(alike, n_window);
    for (std::size_t d = 0, j = 0; d < modes.size(); ++d) {
      if (!found[d].is_alike) continue;
      const double move = moves[static_cast<Eigen::Index>(j)];
      later[d] += move;
      alike[j] = audio::phase_shifted(alike[j], omega * move);
      ++j;
    }
    if (moves.cwiseAbs().maxCoeff() < kLittleMove) break;
  }
  return later;
}

}  // namespace bouncelab::detection
