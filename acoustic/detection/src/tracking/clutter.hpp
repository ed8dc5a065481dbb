// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"

namespace bouncelab::detection {

constexpr int kChanceOctaves = 12;

/// Candidates around one, itself included, each counted by how much it is a rival (band_energies.hpp).
struct Rivals {
  std::array<float, kChanceOctaves> density{};  ///< of their log amplitudes at this one's, within 2 ms, 4 ms ... 4 s
  float all = 0.0F;                             ///< number within 4 s
  float stronger = 0.0F;                        ///< of these, at least as strong
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

/// Intensity of the clutter at this candidate, per second and unit of log amplitude: a kernel estimate over the
/// candidates within rival_window_s, itself included. What sounds otherwise is no rival.
/// @param own  density that the track's own sounds contribute: they are no clutter
double clutter_intensity(const Rivals& rivals, double flight_s, double own);

/// What one sound contributes to the density of log amplitudes at another's.
double amplitude_kernel(double log_ratio);

/// Odds against a candidate as the one with which a train begins, r H_n within 4 s.
double chance_of_first(const Rivals& rivals);

/// log of p(LLR | impact) / p(LLR | any candidate around), for each candidate: what its rise says about whether it is
/// an event at all.
///
/// Where a sound rings, its variance fluctuates, and candidates stand wherever that passes the threshold: their LLR
/// exceeds it by an exponentially distributed amount. What an event adds has no scale: LLR - threshold = z has the
/// density z0 / (z0 + z)^2. The share of events among the candidates around, and the mean excess of the others, are
/// estimated from the nearest ones in time.
/// @param n_in_window  samples in the shortest window of a candidate; LLR is in proportion to it
std::vector<double> log_rise_odds(const std::vector<Candidate>& candidates, double n_in_window);

/// Student's t with three degrees of freedom: a normal core, tails that forgive.
double student3(double x, double width);

}  // namespace bouncelab::detection
