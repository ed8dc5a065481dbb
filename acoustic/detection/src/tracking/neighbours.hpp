// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"
#include "tracking/densities.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

constexpr int kWindowOctaves = 12;
constexpr double kSmallestReach_s = 2e-3;
constexpr double kLargestReach_s = kSmallestReach_s * (1 << (kWindowOctaves - 1));  // 4 s

/// Candidates around one, itself included, each counted by how much it is of the same kind (band_energies.hpp).
struct Neighbours {
  std::array<float, kWindowOctaves> density{};  ///< of their log amplitudes at this one's, within 2 ms, 4 ms ... 4 s
  float all = 0.0F;                             ///< number within 4 s
  float stronger = 0.0F;                        ///< of these, at least as strong
  float around_s = 0.0F;                        ///< of the recording that is within 4 s
};

/// Those of one candidate, itself included, but for some.
/// @param log_amplitude  of each candidate
/// @param not_counted    indices, rising
Neighbours count_neighbours(std::size_t candidate, const std::vector<Candidate>& candidates,
                            std::span<const double> log_amplitude, const SameSource& same_source,
                            const std::vector<std::size_t>& not_counted);

/// The window in which sounds compete for being the impact after this flight: about two flights either way [s].
double clutter_window_s(double flight_s);

/// Intensity of the clutter at a candidate [1/s, per unit of log amplitude]: a kernel estimate over the candidates
/// within clutter_window_s, itself included.
/// @param own  density that the track's own sounds contribute: they are no clutter
double clutter_intensity(const Neighbours& neighbours, double flight_s, double own);

/// The same of one around which none of the track's own are counted. A gamma prior, worth kTracking.unseen sounds,
/// whose mean is the intensity within 4 s: in a quiet recording the first loud sound is no sign of others beside it.
double clutter_intensity(const Neighbours& neighbours, double flight_s);

/// The least that it may be, where all others are the track's own.
double least_clutter_intensity(double flight_s);

/// What one sound contributes to the density of log amplitudes at another's.
inline double amplitude_kernel(double log_ratio) { return student3(log_ratio, kTracking.kernel_width); }

/// log of the odds against a candidate as the one with which a track begins. The candidate of rank r among the n within
/// 4 s gets the share 1/(r H_n), H_n = 1 + 1/2 + ... + 1/n: strong ones are the likelier impacts, and the shares sum up
/// to 1.
double log_odds_against_first(const Neighbours& neighbours);

}  // namespace bouncelab::detection
