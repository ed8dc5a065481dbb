// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// One block of a recording with margins on both sides: its sound, the innovations, and their running energy from hop
/// to hop. Each sample's energy is raised by a hundredth of the quiet variance: digital silence is no background.
class InnovationEnergy {
 public:
  /// @param sound, model  kept by reference
  /// @param hop           samples, > 0
  /// @param margin_hops   on either side of a block
  InnovationEnergy(const audio::AudioSource& sound, const ArModel& model, std::int64_t hop, std::int64_t margin_hops)
      : sound_(sound), model_(model), hop_(hop), margin_hops_(margin_hops), floor_(0.01 * model.quiet_variance) {}

  /// Loads the next block; blocks come in order, and what the last one holds of this one is kept.
  void load(std::int64_t first_hop, std::int64_t n_hops);

  double rate_hz() const { return sound_.rate_hz; }
  double quiet_variance() const { return model_.quiet_variance; }
  std::int64_t hop() const { return hop_; }

  double of_hops(std::int64_t from, std::int64_t to) const {
    return running_[static_cast<std::size_t>(to - first_hop_)] - running_[static_cast<std::size_t>(from - first_hop_)];
  }
  /// At which of n hops, up to 64, a bit each: factor (energy of after_hops after it) >= least (energy of factor
  /// after_hops before it).
  std::uint64_t rises(std::int64_t first, std::int64_t n, std::int64_t after_hops, std::int64_t factor,
                      double least) const;
  /// Of samples first ... last - 1; whole hops by their running sum.
  double of_samples(std::int64_t first, std::int64_t last) const { return before_sample(last) - before_sample(first); }
  /// Samples first ... first + out.size() - 1 of the recording, within the block and its margins; 0 outside of it.
  void copy_sound(std::int64_t first, std::span<float> out) const;
  /// From sample to sample: out[k] = energy of samples first ... first + k - 1.
  std::vector<double> running(std::int64_t first, std::int64_t last) const;

 private:
  void sum_hops(const float* x, double floor);
  /// Of the samples from the first of the margin to this one.
  double before_sample(std::int64_t sample) const;
  /// @param n_held  samples of the block that are there already
  void read_innovations_padded(std::int64_t n_held);
  void hold_sound(std::int64_t n_held);

  const audio::AudioSource& sound_;
  const ArModel& model_;
  std::int64_t hop_;
  std::int64_t margin_hops_;
  double floor_;
  std::int64_t first_hop_ = 0;  // of the margin
  // the sound from the samples on that the first innovation is predicted from
  std::vector<float> sound_held_;
  std::int64_t sound_first_ = 0;
  std::vector<float> innovations_;
  std::vector<double> running_;
};

}  // namespace bouncelab::detection
