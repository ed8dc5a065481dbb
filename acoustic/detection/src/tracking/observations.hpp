// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "candidates/candidates.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

constexpr int kWindowOctaves = 12;
constexpr double kSmallestReach_s = 2e-3;
constexpr double kLargestReach_s = kSmallestReach_s * (1 << (kWindowOctaves - 1));  // 4 s

/// Candidates around one, itself included, each counted by how much it is of the same kind (SameSource). What is so
/// near that it is the same sound, noticed twice, is none (kTracking.same_sound_s).
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

/// log of p(LLR | event) / p(LLR | any candidate around), for each candidate: what its rise says about whether it is an
/// event at all.
///
/// Where a sound rings, its variance fluctuates, and candidates stand wherever that passes the threshold: there z = LLR
/// - threshold is distributed exponentially, with a mean of 1 in white noise and of some units in a ringing sound. What
/// an event adds has no scale: z has the density z0 / (z0 + z)^2. The share of events among the nearest candidates in
/// time is estimated by expectation and maximisation, with a prior of one half.
/// @param n_in_window  samples in the shortest window of a candidate; LLR is in proportion to it
std::vector<double> log_rise_odds(const std::vector<Candidate>& candidates, double n_in_window);

/// A candidate as the model of tracks sees it.
struct Observation {
  double t_s = 0.0;
  double sigma_s = 0.0;  ///< error of the time
  double log_amplitude = 0.0;
  double log_rise_odds = 0.0;      ///< that it is an event at all (log_rise_odds())
  double log_odds_of_first = 0.0;  ///< of a track that begins with it, before its second impact
  Neighbours neighbours;
  /// The flight after the first impact of a drop, were that elastic: of a height that is known.
  std::optional<double> elastic_flight_s{};
};

/// Those of a recording. Refers to what it is made from.
class Observations {
 public:
  /// @param timing_s       error of the times that the shortest window gives [s]
  /// @param same_source    which of the candidates may have one source
  /// @param duration_s     of the recording, from 0 on
  Observations(const std::vector<Candidate>& candidates, double timing_s, const SameSource& same_source,
               double duration_s = HUGE_VAL, std::optional<double> elastic_flight_s = {});

  std::size_t size() const { return observations_.size(); }
  const Observation& operator[](std::size_t k) const { return observations_[k]; }
  std::span<const Observation> all() const { return observations_; }
  /// The same with what a track explains not counted among its neighbours.
  /// @param explained  indices, rising
  Observation without(std::size_t k, const std::vector<std::size_t>& explained) const;
  /// Weight of one as clutter for the other, or as an impact of the same ball: 1 where they cannot be told apart.
  double same_source(std::size_t j, std::size_t k) const { return same_source_.weight(j, k); }
  double same_source_probability(std::size_t j, std::size_t k) const { return same_source_.probability(j, k); }
  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  const std::vector<Candidate>& candidates_;
  const SameSource& same_source_;
  double duration_s_;
  std::vector<double> log_amplitudes_;
  std::vector<Observation> observations_;
};

}  // namespace bouncelab::detection
