// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "candidates/candidates.hpp"

namespace bouncelab::detection {

constexpr int kEnergyBands = 8;  // octaves from 90 Hz on

/// What a sound brings in each octave over what was there before it.
struct BandEnergies {
  std::array<float, kEnergyBands> log_power{};    ///< ln of the power added, or of the least that would be noticed
  std::array<float, kEnergyBands> added_share{};  ///< share of it in the power heard, 0 ... 1
};

/// Of the 12 ms after each candidate against the 12 ms before it, differenced, under half a Hann window.
std::vector<BandEnergies> measure_band_energies(const audio::AudioSource& sound,
                                                const std::vector<Candidate>& candidates);

/// Probability that two sounds are of one kind (a ball's impacts, one voice, one pair of hands) where half of all pairs
/// are: how far their spectra differ beside their loudness. Of one kind they scatter by 4 dB an octave, of two by 11
/// dB; an octave in which neither is added_share says nothing. .02 ... .98.
float same_source_probability(const BandEnergies& a, const BandEnergies& b);

/// How much one sound is a rival of another, or of its train: fully, where nothing tells them apart.
constexpr double same_source_weight(double same_source_probability) {
  return same_source_probability < 0.5 ? 2.0 * same_source_probability : 1.0;
}

}  // namespace bouncelab::detection
