// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {

constexpr int kEnergyBands = 8;  // octaves from 90 Hz on

/// Energy that a sound adds in each octave to what was there before.
struct BandEnergies {
  std::array<float, kEnergyBands> log_power{};    ///< ln of the power added, or of the least that could be detected
  std::array<float, kEnergyBands> added_share{};  ///< of the power added in the power before and after, 0 ... 1
};

/// Measures them: of 12 to 23 ms after a candidate against as much before it, differenced, under half a Hann window.
class BandEnergyMeter {
 public:
  explicit BandEnergyMeter(double rate_hz);

  /// The sound around a sample that is needed: from reach() + 1 samples before it to reach() - 1 after it.
  std::int64_t reach() const { return static_cast<std::int64_t>(window_.size()); }
  /// @param sound  those 2 reach() + 1 samples
  BandEnergies measure(std::span<const float> sound) const;

 private:
  audio::RealFft fourier_;
  std::array<std::size_t, kEnergyBands + 1> begin_;  ///< first bin of each octave
  std::vector<float> window_;
};

/// Weights of sounds as clutter for one another: twice the probability that they have one source, 1 at most. One sound
/// is compared with a row of others at once, since dense music has a million pairs a minute.
class SameSource {
 public:
  SameSource() = default;  ///< Nothing is known: all weights are 1, as of no band energies.
  explicit SameSource(const std::vector<BandEnergies>& band_energies);

  /// Of sound k and each of the sounds first ... first + weights.size() - 1.
  void weigh(std::size_t k, std::size_t first, std::span<float> weights) const;
  float weight(std::size_t j, std::size_t k) const;
  /// The same of some of the sounds.
  SameSource of(const std::vector<std::size_t>& sounds) const;
  /// Probability that two sounds are of one source (a ball's impacts, one voice, one pair of hands), prior 1/2, by how
  /// far their spectra differ once their loudness is taken out: normal distributions of 4 dB an octave for one source,
  /// of 11 dB for two. Octaves are weighted by the added shares of both. 0.02 ... 0.98.
  float probability(std::size_t j, std::size_t k) const;

 private:
  BandEnergies operator[](std::size_t k) const;

  std::size_t n_sounds_ = 0;
  std::vector<float> power_, share_;  ///< of all sounds in the first octave, then in the second ...
};

}  // namespace bouncelab::detection
