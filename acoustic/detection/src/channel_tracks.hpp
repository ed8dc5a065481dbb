// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/parallel.hpp"
#include "candidates/candidates.hpp"
#include "model_number.hpp"
#include "tracking/tracker.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {

/// The numbers of the choice between channels and bands (docs/detector.md, "Bands and channels").
struct ChannelModel {
  double same_ball = 0.25;  ///< share of their log odds by which channels with the same impacts differ
  // Lower bands are not searched where they have nothing to add: where the impacts are nearly all that rises (of balls
  // of steel, glass and stone 0.99, of soft ones 0.2 to 0.99), and none is so faint that others may be missing.
  double explained = 0.97;
  double clear_rise = 8.0;       ///< beyond the threshold of candidates
  std::int64_t n_compared = 48;  ///< samples after two candidates of a lower band: 12 and 48 ms
  double edge_s = 3e-3;  ///< from sound that a file has lost: reach of the windows in which a rise is looked for
};

BOUNCELAB_MODEL ChannelModel kChannels;

/// Poles of the models of a channel: enough for the strongest twenty-odd modes of a plate; more gain nothing in noise.
constexpr int kArOrder = 48;

/// One channel, whole or the low frequencies of it, what may be impacts there, and the balls' tracks of those.
struct BandOfChannel {
  audio::AudioSource sound{};
  int decimation = 1;  ///< of the recording's sampling rate; 1 = all frequencies
  ArModels models{};   ///< without filter where the band is not searched yet
  std::vector<Candidate> candidates{};
  SameSource same_source{};
  std::vector<Track> tracks{};

  double log_odds() const;  ///< of all tracks
};

/// A channel in bands, and the one of them that its drops are taken from.
struct SearchedChannel {
  std::size_t channel = 0;  ///< of those to choose from
  std::vector<BandOfChannel> bands;
  std::size_t best = 0;  ///< band where the tracks are the most probable
};

/// All frequencies, those below 2 kHz and those below 500 Hz: rubber balls are faint above 1.5 kHz, a basketball above
/// 300 Hz. None is searched yet, and the lower ones have no sound.
std::vector<BandOfChannel> bands_of(audio::AudioSource sound);

/// Searches a band for candidates, after those before it, of which the next one gives its sound.
/// @param bands      of bands_of(); the sound may be read by several threads where n_threads is not 1
/// @param n_threads  that search
void find_candidates_of(std::vector<BandOfChannel>& bands, std::size_t b, int n_threads = 1,
                        const ProgressCallback& progress = {});

/// Searches bands for candidates, where that is not done yet, and these for tracks, one band after the other; none that
/// is lower where the tracks of the whole band are clear: where the impacts are nearly all that rises and none is faint
/// there is nothing else.
/// @param elastic_flight_s  Observation::elastic_flight_s; the rest as of find_candidates_of()
SearchedChannel search_channel(std::vector<BandOfChannel> bands, std::optional<double> elastic_flight_s = {},
                               int n_threads = 1, const ProgressCallback& progress = {});

/// Chooses the channel whose tracks are the most probable; of those that have recorded the same ball, that in which its
/// impacts rise the most (is_preferred); of equal ones the first.
/// @param channels   at least one; the rest as of search_channel()
SearchedChannel choose_channel(std::span<const audio::AudioSource> channels, std::optional<double> elastic_flight_s,
                               int n_threads, const ProgressCallback& progress);

/// Whether one channel is to be preferred to another: the one of the more probable tracks; where both have recorded the
/// same ball, the one in which its impacts rise the more, since that makes their times accurate.
/// @param band, other  the best of either
bool is_preferred(const BandOfChannel& band, const BandOfChannel& other);

}  // namespace bouncelab::detection
