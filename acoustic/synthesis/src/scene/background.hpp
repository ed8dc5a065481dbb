// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "scene/noise.hpp"
#include "scene/schedule.hpp"
#include "sensor/converter.hpp"

namespace bouncelab::synthesis {

/// Everything in a channel that is not a strike on the ground: noise, hum, drift, clicks, speech. A function of time:
/// any part can be computed.
class Background {
 public:
  /// All must outlive this.
  Background(const SynthesisConfig& config, const Schedule& schedule, const ConverterFilter& filter,
             const Levels& levels);
  /// Nothing but white noise: it can be added in short pieces at no cost.
  bool is_white() const;
  /// Adds frames first ... first + out.size() - 1 of one channel.
  template <class T>
  void add_white(std::size_t channel, std::int64_t first, std::span<T> out) const {
    WhiteNoise(config_.seed, channel).add(first, levels_.noise_rms, out);
  }
  /// The same of any background; coloured noise has a run-in for each call.
  void add(std::size_t channel, std::int64_t first, std::span<double> out) const;

 private:
  void add_noise(std::size_t channel, std::int64_t first, std::span<double> out) const;
  void add_hum_and_drift(std::int64_t first, std::span<double> out) const;
  void add_clicks(std::int64_t first, std::span<double> out) const;
  /// The whole of a syllable, of peak 1: a voice whose pitch falls, through three formants.
  std::vector<double> voice(const Syllable& syllable, std::size_t n) const;
  void add_syllable(const Syllable& syllable, std::int64_t first, std::span<double> out) const;

  const SynthesisConfig& config_;
  const Schedule& schedule_;
  const ConverterFilter& filter_;
  Levels levels_;
  FlickerFilter flicker_;
};

}  // namespace bouncelab::synthesis
