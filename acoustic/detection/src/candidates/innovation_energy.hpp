// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// A stretch of a recording: its sound, the innovations, and their running energy from hop to hop. Each sample's energy
/// is raised by a hundredth of the quiet variance: digital silence is no background.
class InnovationEnergy {
 public:
  /// @param hop        samples, > 0
  /// @param first_hop  of the stretch, which may begin before the recording and end after it
  InnovationEnergy(const audio::AudioSource& sound, const ArModel& model, std::int64_t hop, std::int64_t first_hop,
                   std::int64_t n_hops);

  double rate_hz() const { return rate_hz_; }
  double quiet_variance() const { return quiet_variance_; }
  std::int64_t hop() const { return hop_; }

  double of_hops(std::int64_t from, std::int64_t to) const {
    return running_[static_cast<std::size_t>(to - first_hop_)] - running_[static_cast<std::size_t>(from - first_hop_)];
  }
  /// Of samples first ... last - 1; whole hops by their running sum.
  double of_samples(std::int64_t first, std::int64_t last) const { return before_sample(last) - before_sample(first); }
  /// From sample to sample: out[k] = energy of samples first ... first + k - 1.
  std::vector<double> running(std::int64_t first, std::int64_t last) const;
  /// The recording from a sample on; 0 outside of it.
  std::span<const float> sound(std::int64_t first, std::int64_t n) const {
    return std::span(sound_).subspan(static_cast<std::size_t>(first - sound_first_), static_cast<std::size_t>(n));
  }

 private:
  /// Of the samples from the first of the stretch to this one.
  double before_sample(std::int64_t sample) const;

  double rate_hz_;
  double quiet_variance_;
  double floor_;
  std::int64_t hop_;
  std::int64_t first_hop_;
  std::int64_t sound_first_;  // from which the first innovation is predicted
  std::vector<float> sound_;
  std::vector<float> innovations_;
  std::vector<double> running_{0.0};
};

}  // namespace bouncelab::detection
