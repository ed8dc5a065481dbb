// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "candidates/candidates.hpp"
#include "tracking/observations.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// One impact of a track.
struct TrackImpact {
  std::size_t candidate = 0;  ///< index into the candidates
  std::int64_t impact = 0;    ///< number within the track; jumps where an impact was not detected
  double probability = 1.0;   ///< that it is one of the ball's, given that the track is a ball's
};

/// One drop: the candidates that are the impacts of one ball.
struct Track {
  std::vector<TrackImpact> impacts;
  double log_odds = 0.0;  ///< of the ball against clutter and rhythms
};

constexpr std::int64_t kFewestImpacts = 3;  // one coefficient of restitution

/// Correlation of the sounds after two candidates, 0 ... 1.
using Likeness = std::function<double(std::size_t, std::size_t)>;

/// Ratio of the flights after and before the k-th detected impact, by the candidates' times; absent at the ends and
/// beside impacts that were not detected.
std::optional<double> eps_at(const std::vector<Candidate>& candidates, const Track& track, std::size_t k);

/// The most probable tracks of a recording, one after the other in time: multiple hypothesis tracking (Reid 1979,
/// doi:10.1109/TAC.1979.1102177; Blackman & Popoli 1999) of a bouncing ball in clutter, by a beam search over
/// hypotheses (hypothesis.hpp), each impact of which may be followed by up to kMostMissing that were not detected. Each
/// track is then scored anew without its own sounds among the clutter, weighed by how alike its impacts sound and by
/// how often balls are dropped in the recording (weigh_by_drop_rate); those of even odds at least are left.
/// @param timing_s     error of the candidates' times, standard deviation [s]; where only a longer window noticed
///                        one, 0.15 of that window
/// @param same_source  which of the candidates may have one source
/// @param duration_s   of the recording, from 0 on
/// @param elastic_flight_s  Observation::elastic_flight_s
/// @param likeness          of candidates; without it nothing is known of how alike they sound
std::vector<Track> find_tracks(const std::vector<Candidate>& candidates, double timing_s,
                               const SameSource& same_source = {}, double duration_s = HUGE_VAL,
                               std::optional<double> elastic_flight_s = {}, const Likeness& likeness = {});

/// log of the odds that impacts which follow one another sound so much alike. The band energies of SameSource say what
/// cannot be of one source; this says what is.
double log_odds_of_likeness(const Track& track, const Likeness& likeness);

/// The likeliest balls one after the other in time, among the sounds of a stretch of time that are not taken.
/// @param taken      indices of candidates, rising
/// @param explained  those that chance need not offer: the taken ones and their echoes
std::vector<Track> find_balls(const Observations& observations, const std::vector<std::size_t>& taken,
                              const std::vector<std::size_t>& explained, double begin_s = -HUGE_VAL,
                              double end_s = HUGE_VAL);

/// A track's own sounds and their echoes: chance need not offer them. @return indices, rising
std::vector<std::size_t> explained_by(const Observations& observations, const Track& track);
/// What the tracks explain that go on while one of them does, but that one; of the number of tracks, what all explain.
/// @return indices, rising
std::vector<std::size_t> explained_by_others(const Observations& observations, const std::vector<Track>& tracks,
                                             std::size_t but);

/// Those in either, rising.
std::vector<std::size_t> united(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b);

/// Log odds of a track against clutter, and against rhythms of the same sounds too, where what it and others explain
/// does not compete with its sounds.
struct LogOdds {
  double ball = -HUGE_VAL, ball_against_rhythm = -HUGE_VAL;
};
LogOdds log_odds_of(const Observations& observations, const Track& track, const std::vector<std::size_t>& by_others);

/// The tracks once more, now that the balls are known: which observation each begins with, and its log odds with its
/// own sounds and their echoes not counted as clutter. What a surer track has claimed since is no other's.
/// @param tracks  one after the other in time
std::vector<Track> rescored(const Observations& observations, std::vector<Track> tracks);

/// Puts balls that bounce at the same time in the place of tracks that hold sounds of several. Each is searched among
/// the sounds that the others leave, in turns, until none changes. They are taken where together they are more probable
/// than one ball and than the tracks that there are.
/// @param tracks  one after the other in time; then in the order of their first impacts
void add_balls_at_once(const Observations& observations, std::vector<Track>& tracks);

/// Weighs tracks by how often balls are dropped in their recording, which is not known: the rate lies between about one
/// drop in the whole recording and TrackingModel::start_log_odds, every order of magnitude as probable as another
/// (Jeffreys 1946, doi:10.1098/rspa.1946.0056), and the other tracks tell. So a random row of sounds in an hour of
/// music needs better reasons than three knocks in a clip of three seconds, and many drops speak for each other.
/// @param candidates  of the recording; time without them offers no chance
/// @param tracks      with log odds for the largest rate; they are lowered
void weigh_by_drop_rate(const std::vector<Candidate>& candidates, std::vector<Track>& tracks);

/// Sets the probability of each impact of a track to be one of the ball's, given that the track is that of a ball.
///
/// The track is weighed against its nearest others, each by the score of a hypothesis (hypothesis.hpp) over the few
/// impacts in which the two differ:
///
/// - without the impact, which then is clutter, while the ball's own was not detected;
/// - with another candidate in its place;
/// - ended before it; begun after it.
///
///   p = sum of the weights of those with the impact / sum of all weights
/// @param by_others  candidates that other tracks explain, indices, rising
void set_impact_probabilities(const Observations& observations, Track& track,
                              const std::vector<std::size_t>& by_others = {});

/// Probability of an impact found where its track predicts one, from its significance. There either is an impact, whose
/// log likelihood ratio may be any, or the largest of n_places squared normals is taken for one, odds of exp(LLR) /
/// n_places, or another sound that no candidate stands for, at odds of kTracking.other_sound.
/// @param llr       over the variance of noise and unexplained sound there
/// @param n_places  independent ones of the search, > 0
double probability_of_inferred(double llr, double n_places);

/// Whether there is a candidate within its reach of a time. An inferred impact there has the probability
/// kTracking.refused: the candidate was weighed in the search for tracks, and left out.
bool is_at_candidate(const std::vector<Candidate>& candidates, double t_s);

/// p(a mark is an impact of this ball) = p(track) p(impact | track), to six decimals.
/// @param log_odds  of the track
double probability_of_mark(double log_odds, double of_impact);

}  // namespace bouncelab::detection
