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

/// One channel, whole or the low frequencies of it, and what may be impacts there.
struct BandOfChannel {
  audio::AudioSource sound;
  int decimation = 1;  ///< of the recording's sampling rate; 1 = all frequencies
  ArModels models;
  std::vector<Candidate> candidates;
  SameSource same_source;
  std::optional<double> elastic_flight_s{};  ///< Observation::elastic_flight_s
};

/// All frequencies, those below 2 kHz and those below 500 Hz: rubber balls are faint above 1.5 kHz, a basketball above
/// 300 Hz. Each is searched for candidates, after those above it, when it is first asked for.
class BandsOfChannel {
 public:
  /// @param sound      may be read by several threads where n_threads is not 1
  /// @param n_threads  that search it
  /// @param elastic_flight_s  Observation::elastic_flight_s
  explicit BandsOfChannel(audio::AudioSource sound, int n_threads = 1, ProgressCallback progress = {},
                          std::optional<double> elastic_flight_s = {});
  explicit BandsOfChannel(std::vector<BandOfChannel> searched);
  std::size_t size() const { return bands_.size(); }
  BandOfChannel& operator[](std::size_t band);

 private:
  void search(std::size_t b);

  int n_threads_ = 1;
  ProgressCallback progress_;
  std::vector<BandOfChannel> bands_;
  std::size_t n_searched_ = 0;
};

/// The tracks of a channel, in the band where they are most probable.
struct ChannelTracks {
  struct OfBand {
    std::size_t band = 0;
    std::vector<Track> tracks;
  };
  std::size_t band = 0;
  std::vector<Track> tracks;
  std::vector<OfBand> others;  ///< of the other bands that were searched and have any
  /// The impacts are nearly all that rises in the whole band, and none is faint: there is nothing else to find.
  bool is_clear = false;
  double log_odds() const;
};

/// Lower bands are not searched where the tracks of the whole band are clear.
ChannelTracks find_tracks_in(BandsOfChannel& bands);

/// The channel that detection is from.
struct ChosenChannel {
  std::size_t channel = 0;  ///< of those to choose from
  BandOfChannel band;
  std::vector<BandOfChannel> other_bands;  ///< of found.others
  ChannelTracks found;
};

/// Chooses the channel whose tracks are the most probable; of those that have recorded the same ball, that in which its
/// impacts rise the most (is_preferred); of equal ones the first.
/// @param channels   at least one; sources that may be read by several threads where n_threads is not 1
/// @param n_threads  that search
/// @param elastic_flight_s  Observation::elastic_flight_s
ChosenChannel choose_channel(std::span<const audio::AudioSource> channels, int n_threads,
                             const ProgressCallback& progress, std::optional<double> elastic_flight_s = {});

/// Whether one channel is to be preferred to another: the one of the more probable tracks; where both have recorded the
/// same ball, the one in which its impacts rise the more, since that makes their times accurate.
bool is_preferred(const BandOfChannel& band, const ChannelTracks& found, const BandOfChannel& other_band,
                  const ChannelTracks& other);

}  // namespace bouncelab::detection
