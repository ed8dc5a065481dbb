// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/innovation_energy.hpp"

#include <algorithm>
#include <cmath>

namespace bouncelab::detection {
namespace {

float energy_of(float x) { return x * x; }

}  // namespace

InnovationEnergy::InnovationEnergy(const audio::AudioSource& sound, const ArModel& model, std::int64_t hop,
                                   std::int64_t first_hop, std::int64_t n_hops)
    : rate_hz_(sound.rate_hz),
      quiet_variance_(model.quiet_variance),
      floor_(0.01 * model.quiet_variance),
      hop_(hop),
      first_hop_(first_hop) {
  const std::int64_t n_predicting = std::ssize(model.filter) - 1;
  const std::int64_t first = first_hop * hop, last = first + n_hops * hop;
  sound_first_ = first - n_predicting;
  sound_.resize(static_cast<std::size_t>(last - sound_first_));
  read_padded(sound, sound_first_, sound_);
  // the quiet level before the samples that the model needs to predict the first innovation, and after the last
  innovations_.assign(static_cast<std::size_t>(last - first), static_cast<float>(std::sqrt(quiet_variance_)));
  const std::int64_t lo = std::clamp<std::int64_t>(std::min(n_predicting, sound.n_samples), first, last);
  const std::int64_t hi = std::clamp<std::int64_t>(sound.n_samples, lo, last);
  if (hi > lo)
    innovations_of(this->sound(lo - n_predicting, hi - lo + n_predicting), model,
                   std::span(innovations_).subspan(lo - first, hi - lo));
  const float* x = innovations_.data();
  for (std::int64_t k = 0; k < n_hops; ++k) {
    float energy = 0.0F;
    for (std::int64_t j = 0; j < hop; ++j) energy += energy_of(*x++);
    running_.push_back(running_.back() + (static_cast<double>(energy) + floor_ * static_cast<double>(hop)));
  }
}

std::vector<double> InnovationEnergy::running(std::int64_t first, std::int64_t last) const {
  std::vector<double> sums(static_cast<std::size_t>(last - first) + 1);
  const float* x = innovations_.data() + (first - first_hop_ * hop_);
  double sum = 0.0;
  for (std::size_t k = 1; k < sums.size(); ++k, ++x)
    sums[k] = sum = sum + (static_cast<double>(energy_of(*x)) + floor_);
  return sums;
}

double InnovationEnergy::before_sample(std::int64_t sample) const {
  const std::int64_t offset = sample - first_hop_ * hop_;
  const std::int64_t n_hops = offset / hop_;
  double sum = running_[static_cast<std::size_t>(n_hops)];
  const float* x = innovations_.data();
  for (std::int64_t k = n_hops * hop_; k < offset; ++k) sum += static_cast<double>(energy_of(x[k])) + floor_;
  return sum;
}

}  // namespace bouncelab::detection
