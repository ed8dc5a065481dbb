// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// One impact of a track.
struct TrackImpact {
  std::size_t candidate = 0;  ///< index into the candidates
  std::int64_t impact = 0;    ///< number within the track; jumps where an impact was not detected
  double probability = 1.0;   ///< that it is one of the ball's, given that the track is a ball's (impact_odds.hpp)
};

/// One drop: the candidates that are the impacts of one ball.
struct Track {
  std::vector<TrackImpact> impacts;
  double log_odds = 0.0;  ///< of the ball against clutter and rhythms
};

constexpr std::int64_t kFewestImpacts = 3;  // one coefficient of restitution

/// Ratio of the flights after and before the k-th detected impact, by the candidates' times; absent at the ends and
/// beside impacts that were not detected.
std::optional<double> eps_at(const std::vector<Candidate>& candidates, const Track& track, std::size_t k);

/// The most probable tracks of a recording, one after the other in time: multiple hypothesis tracking (Reid 1979,
/// doi:10.1109/TAC.1979.1102177; Blackman & Popoli 1999) of a bouncing ball in clutter, by a beam search over
/// hypotheses (hypothesis.hpp), each impact of which may be followed by up to kMostMissing that were not detected. Each
/// track is then scored anew without its own sounds among the clutter and weighed by how often balls are dropped in the
/// recording (rescoring.hpp); those of even odds at least are left.
/// @param timing_s     error of the candidates' times, standard deviation [s]; where only a longer window noticed
///                        one, 0.15 of that window
/// @param same_source  which of the candidates may have one source
/// @param duration_s   of the recording, from 0 on
/// @param elastic_flight_s  Observation::elastic_flight_s
std::vector<Track> find_tracks(const std::vector<Candidate>& candidates, double timing_s,
                               const SameSource& same_source = {}, double duration_s = HUGE_VAL,
                               std::optional<double> elastic_flight_s = {});

}  // namespace bouncelab::detection
