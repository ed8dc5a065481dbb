// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/innovation_energy.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <span>

namespace bouncelab::detection {
namespace {

float square(float x) { return x * x; }

std::uint64_t bits_over(const double* before, const double* at, const double* after, double factor, double least,
                        std::int64_t n) {
  std::uint64_t bits = 0;
  for (std::int64_t k = 0; k < n; ++k)
    bits |= static_cast<std::uint64_t>(factor * (after[k] - at[k]) >= least * (at[k] - before[k]) ? 1 : 0) << k;
  return bits;
}

/// Sums of squares of hops side by side, each in the order of its samples: one by itself would wait for each addition.
template <std::size_t n_hops>
std::array<float, n_hops> energies_of_hops(const float* x, std::int64_t hop) {
  std::array<float, n_hops> sums{};
  for (std::int64_t k = 0; k < hop; ++k)
    for (std::size_t j = 0; j < n_hops; ++j) sums[j] += square(x[static_cast<std::int64_t>(j) * hop + k]);
  return sums;
}

}  // namespace

void InnovationEnergy::load(std::int64_t first_hop, std::int64_t n_hops) {
  const std::int64_t first = first_hop - margin_hops_;
  const std::int64_t n = n_hops + 2 * margin_hops_;
  const std::int64_t n_before = std::ssize(innovations_) / hop_;
  const std::int64_t n_held = std::clamp<std::int64_t>(first_hop_ + n_before - first, 0, std::min(n, n_before));
  std::copy(innovations_.end() - n_held * hop_, innovations_.end(), innovations_.begin());
  innovations_.resize(static_cast<std::size_t>(n * hop_));
  first_hop_ = first;
  read_innovations_padded(n_held * hop_);
  running_.resize(static_cast<std::size_t>(n) + 1);
  sum_hops(innovations_.data(), floor_ * static_cast<double>(hop_));
}

std::uint64_t InnovationEnergy::rises(std::int64_t first, std::int64_t n, std::int64_t after_hops, std::int64_t factor,
                                      double least) const {
  const double* at = running_.data() + (first - first_hop_);
  return bits_over(at - factor * after_hops, at, at + after_hops, static_cast<double>(factor), least, n);
}

std::vector<double> InnovationEnergy::running(std::int64_t first, std::int64_t last) const {
  std::vector<double> sums(static_cast<std::size_t>(last - first) + 1);
  const float* x = innovations_.data() + (first - first_hop_ * hop_);
  double sum = 0.0;
  for (std::size_t k = 1; k < sums.size(); ++k, ++x) sums[k] = sum = sum + (static_cast<double>(*x * *x) + floor_);
  return sums;
}

void InnovationEnergy::sum_hops(const float* x, double floor) {
  constexpr std::int64_t kAtOnce = 8;
  const std::int64_t n_hops = std::ssize(running_) - 1;
  double sum = 0.0;
  std::int64_t k = 0;
  const auto add = [&](float energy) {
    running_[static_cast<std::size_t>(++k)] = sum += static_cast<double>(energy) + floor;
  };
  running_[0] = sum;
  while (k + kAtOnce <= n_hops)
    for (const float energy : energies_of_hops<kAtOnce>(x + k * hop_, hop_)) add(energy);
  while (k < n_hops) add(energies_of_hops<1>(x + k * hop_, hop_).front());
}

double InnovationEnergy::before_sample(std::int64_t sample) const {
  const std::int64_t offset = sample - first_hop_ * hop_;
  const std::int64_t n_hops = offset / hop_;
  double sum = running_[static_cast<std::size_t>(n_hops)];
  const float* x = innovations_.data();
  for (std::int64_t k = n_hops * hop_; k < offset; ++k) sum += static_cast<double>(square(x[k])) + floor_;
  return sum;
}

void InnovationEnergy::copy_sound(std::int64_t first, std::span<float> out) const {
  assert(first >= sound_first_ && first + std::ssize(out) <= sound_first_ + std::ssize(sound_held_));
  std::copy_n(sound_held_.begin() + (first - sound_first_), out.size(), out.begin());
}

void InnovationEnergy::read_innovations_padded(std::int64_t n_held) {
  // the quiet level before the samples that the model needs to predict the first innovation, and after the last
  const std::int64_t begin = first_hop_ * hop_;
  const std::int64_t first = begin + n_held;
  const std::int64_t last = begin + std::ssize(innovations_);
  const std::int64_t n_known = std::min<std::int64_t>(std::ssize(model_.filter) - 1, sound_.n_samples);
  const std::int64_t lo = std::clamp<std::int64_t>(n_known, first, last);
  const std::int64_t hi = std::clamp<std::int64_t>(sound_.n_samples, lo, last);
  hold_sound(n_held);
  if (hi > lo)
    innovations_of(std::span(sound_held_).subspan(lo - begin, hi - lo + std::ssize(model_.filter) - 1), model_,
                   std::span(innovations_).subspan(lo - begin, hi - lo));
  const auto level = static_cast<float>(std::sqrt(model_.quiet_variance));
  std::fill(innovations_.begin() + n_held, innovations_.begin() + (lo - begin), level);
  std::fill(innovations_.begin() + (hi - begin), innovations_.end(), level);
}

void InnovationEnergy::hold_sound(std::int64_t n_held) {
  const std::int64_t n_predicting = std::ssize(model_.filter) - 1;
  const std::int64_t n_kept = n_held > 0 ? n_held + n_predicting : 0;
  std::copy(sound_held_.end() - n_kept, sound_held_.end(), sound_held_.begin());
  sound_held_.resize(innovations_.size() + static_cast<std::size_t>(n_predicting));
  sound_first_ = first_hop_ * hop_ - n_predicting;
  audio::read_padded(sound_, sound_first_ + n_kept, std::span(sound_held_).subspan(static_cast<std::size_t>(n_kept)));
}

}  // namespace bouncelab::detection
