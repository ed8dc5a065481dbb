// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"

namespace bouncelab::detection {

constexpr int kChanceOctaves = 12;

/// Candidates within 2 ms, 4 ms ... 4 s of one: all of them, itself included, and those at least as strong, each
/// counted by how much it is a rival (band_energies.hpp).
struct Rivals {
  std::array<float, kChanceOctaves> all{};
  std::array<float, kChanceOctaves> stronger{};
};

/// @param band_energies  of the candidates, or none: then all are of one kind
std::vector<Rivals> count_rivals(const std::vector<Candidate>& candidates,
                                 const std::vector<BandEnergies>& band_energies);

/// Those of one candidate, itself included, but for some.
/// @param not_counted  indices, rising
Rivals count_rivals_of(std::size_t candidate, const std::vector<Candidate>& candidates,
                       const std::vector<BandEnergies>& band_energies, const std::vector<std::size_t>& not_counted);

/// The window in which sounds compete for being the impact after this flight: about two flights either way [s].
double rival_window_s(double flight_s);

/// Rate at which chance offers what this candidate offers within rival_window_s [1/s].
///
/// The candidate of rank r among n gets the share 1/(r H_n), H_n = 1 + 1/2 + ... + 1/n: the strong ones are the
/// likelier impacts, and summed over all n the odds that chance alone would offer stay 1. What sounds otherwise is no
/// rival.
/// @param n_own  of the stronger ones in the window, those that belong to the train itself: chance does not offer them
double chance_rate(const Rivals& rivals, double flight_s, double n_own);

/// Odds against a candidate as the one with which a train begins, r H_n within 4 s.
double chance_of_first(const Rivals& rivals);

/// What a rhythm (steps, claps, syllables, a metronome) would offer: the density of the next sound at `gap` times the
/// last interval, about 1, per last interval. Half of all sounds are taken to come in rhythms.
double rhythm_density(double gap);

/// Student's t with three degrees of freedom: a normal core, tails that forgive.
double student3(double x, double width);

}  // namespace bouncelab::detection
