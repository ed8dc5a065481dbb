// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "candidates/candidates.hpp"

namespace bouncelab::detection {

constexpr int kTimbreBands = 8;  // octaves from 90 Hz on

/// What a sound brings in each octave over what was there before it.
struct Timbre {
  std::array<float, kTimbreBands> level{};    ///< ln of the power added, or of the least that would be noticed
  std::array<float, kTimbreBands> audible{};  ///< share of it in the power heard, 0 ... 1
};

/// Of the 12 ms after each candidate against the 12 ms before it, differenced, under half a Hann window.
std::vector<Timbre> read_timbres(const audio::AudioSource& sound, const std::vector<Candidate>& candidates);

/// Probability that two sounds are of one kind (a ball's impacts, one voice, one pair of hands) where half of all pairs
/// are: how far their spectra differ beside their loudness. Of one kind they scatter by 4 dB an octave, of two by 11
/// dB; an octave in which neither is audible says nothing. .02 ... .98.
float probability_alike(const Timbre& a, const Timbre& b);

/// How much one sound is a rival of another, or of its train: fully, where nothing tells them apart.
constexpr double rivalry(double probability_alike) { return probability_alike < 0.5 ? 2.0 * probability_alike : 1.0; }

}  // namespace bouncelab::detection
