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

/// Everything in a channel that is not a strike on the ground: noise, hum, drift, clicks, bursts. A function of time:
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
  /// The same of any background; noise that is coloured and bursts have a run-in for each call.
  void add(std::size_t channel, std::int64_t first, std::span<double> out) const;

 private:
  void add_noise(std::size_t channel, std::int64_t first, std::span<double> out) const;
  void add_hum_and_drift(std::int64_t first, std::span<double> out) const;
  void add_clicks(std::int64_t first, std::span<double> out) const;
  /// Sound of rms 1 from frame `from` of the burst on.
  std::vector<double> rush(const Burst& burst, std::int64_t from, std::size_t n) const;
  std::vector<double> whine(const Burst& burst, std::int64_t from, std::size_t n) const;
  /// The whole of a syllable, of peak 1: a voice whose pitch falls, through three formants.
  std::vector<double> voice(const Burst& burst, std::size_t n) const;
  void add_burst(const Burst& burst, std::int64_t first, std::span<double> out) const;

  const SynthesisConfig& config_;
  const Schedule& schedule_;
  const ConverterFilter& filter_;
  Levels levels_;
  FlickerFilter flicker_;
};

}  // namespace bouncelab::synthesis
