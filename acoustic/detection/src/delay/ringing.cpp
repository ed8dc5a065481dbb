// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/ringing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>

#include <Eigen/Sparse>

#include "bouncelab/audio/dsp/kernels.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRidge = 1e-6;  // of the diagonal: where two impacts are at one time, they share the amplitude

/// The samples that two windows of n samples share, the second one beginning `offset` samples after the first:
/// sample i of the second is sample i + offset of the first.
struct SharedSamples {
  std::size_t begin = 0, size = 0;  // in the second window
  std::size_t begin_in_first = 0;
};

SharedSamples shared_samples(std::int64_t offset, std::size_t n_window) {
  const auto n = static_cast<std::int64_t>(n_window);
  if (std::abs(offset) >= n) return {};
  const std::int64_t begin = std::max<std::int64_t>(0, -offset);
  return {static_cast<std::size_t>(begin), static_cast<std::size_t>(n - std::abs(offset)),
          static_cast<std::size_t>(begin + offset)};
}

}  // namespace

Ringing::Ringing(WhiteSound& white, const ImpactTemplate& learned)
    : white_(white), learned_(learned), fourier_(learned.filter.n_window()) {}

void Ringing::add(double t_s, double amplitude, std::optional<audio::Spectrum> wave) {
  impacts_.push_back({0.0, 0.0, std::move(wave), 0, {}});
  set(impacts_.size() - 1, t_s, amplitude);
}

void Ringing::set(std::size_t k, double t_s, double amplitude) {
  Known& impact = impacts_[k];
  impact.amplitude = std::max(0.0, amplitude);
  if (impact.t_s == t_s) return;
  impact.t_s = t_s;
  impact.first = static_cast<std::int64_t>(std::floor(t_s * white_.source().rate_hz - learned_.contact_index));
  impact.placed.clear();
}

const std::vector<float>& Ringing::placed(Known& impact) {
  if (impact.placed.empty()) {
    const double shift =
        impact.t_s * white_.source().rate_hz - learned_.contact_index - static_cast<double>(impact.first);
    impact.placed = fourier_.inverse(audio::phase_shifted(impact.wave ? *impact.wave : learned_.filter.spectrum(),  //
                                                          -learned_.filter.omega() * shift));
  }
  return impact.placed;
}

std::vector<float> Ringing::window_without(std::int64_t first, std::optional<std::size_t> except) {
  std::vector<float> x(fourier_.size());
  white_.read(learned_.whitener, first, x);
  for (std::size_t k = 0; k < impacts_.size(); ++k) {
    const SharedSamples shared = shared_samples(first - impacts_[k].first, fourier_.size());
    if (k == except || shared.size == 0) continue;
    const float* wave = placed(impacts_[k]).data() + shared.begin_in_first;
    const auto a = static_cast<float>(impacts_[k].amplitude);
    audio::add_scaled(x.data() + shared.begin, -a, wave, shared.size);
  }
  return x;
}

void Ringing::fit_amplitudes(const std::vector<bool>& free) {
  std::vector<std::size_t> unknown;
  for (std::size_t k = 0; k < free.size(); ++k)
    if (free[k]) unknown.push_back(k);
  const auto n = static_cast<Eigen::Index>(unknown.size());
  std::vector<Eigen::Triplet<double>> products;
  Eigen::VectorXd change(n);  // <w_i, x - sum A w>, then what it does to the amplitudes
  for (Eigen::Index i = 0; i < n; ++i) {
    Known& impact = impacts_[unknown[static_cast<std::size_t>(i)]];
    const std::vector<float>& wave = placed(impact);
    change(i) = audio::dot(wave, window_without(impact.first));
    for (Eigen::Index j = i; j < n; ++j) {
      Known& later = impacts_[unknown[static_cast<std::size_t>(j)]];
      const SharedSamples shared = shared_samples(later.first - impact.first, fourier_.size());
      if (shared.size == 0) break;
      const double product = audio::dot(std::span(wave).subspan(shared.begin_in_first, shared.size),
                                        std::span(placed(later)).subspan(shared.begin, shared.size));
      products.emplace_back(j, i, i == j ? (1.0 + kRidge) * product : product);
    }
  }
  Eigen::SparseMatrix<double> normal(n, n);
  normal.setFromTriplets(products.begin(), products.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(normal);
  if (solver.info() != Eigen::Success) return;  // two impacts at one time: leaves them as they are
  change = solver.solve(change);
  for (Eigen::Index i = 0; i < n; ++i) {
    Known& impact = impacts_[unknown[static_cast<std::size_t>(i)]];
    impact.amplitude = std::max(0.0, impact.amplitude + change(i));
  }
}

}  // namespace bouncelab::detection
