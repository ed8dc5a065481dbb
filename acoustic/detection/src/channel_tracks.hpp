// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/detection/detect.hpp"
#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"
#include "tracking/tracker.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// Poles of the models of a channel: enough for the strongest twenty-odd modes of a plate; more gain nothing in noise.
constexpr int kArOrder = 48;

/// One channel, whole or the low frequencies of it, and what may be impacts there.
struct BandOfChannel {
  audio::AudioSource sound;
  int decimation = 1;  ///< of the recording's sampling rate; 1 = all frequencies
  ArModels models;
  std::vector<Candidate> candidates;
  SameSource same_source;
};

/// All frequencies, those below 2 kHz and those below 500 Hz: rubber balls are faint above 1.5 kHz, a basketball above
/// 300 Hz. Each is searched for candidates when it is first asked for.
class BandsOfChannel {
 public:
  /// @param sound      may be read by several threads where n_threads is not 1
  /// @param n_threads  that search it
  explicit BandsOfChannel(audio::AudioSource sound, int n_threads = 1, ProgressCallback progress = {});
  explicit BandsOfChannel(std::vector<BandOfChannel> searched);
  std::size_t size() const { return bands_.size(); }
  BandOfChannel& operator[](std::size_t band);

 private:
  const audio::AudioSource& sound_of(std::size_t band);

  int n_threads_ = 1;
  ProgressCallback progress_;
  std::vector<int> decimations_;
  std::vector<std::optional<audio::AudioSource>> sounds_;  ///< made when first asked for
  std::vector<std::optional<BandOfChannel>> bands_;
};

/// Another ball that bounces while a drop is going on; it is said, and not timed.
struct SecondBall {
  double begin_s = 0.0;
  std::size_t n_impacts = 0;
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
  std::optional<SecondBall> second_ball{};
  double log_odds() const;
};

/// Lower bands are not searched where the tracks of the whole band are clear.
ChannelTracks find_tracks_in(BandsOfChannel& bands);

/// Of what the tracks leave over, echoes of their impacts aside, the likeliest track that overlaps one of them in time,
/// if a ball is ten times likelier than chance.
std::optional<SecondBall> second_ball(const BandOfChannel& band, const std::vector<Track>& tracks);

/// How much all impacts of the tracks rise in a band.
double rise_of_impacts(const BandOfChannel& band, const ChannelTracks& found);

}  // namespace bouncelab::detection
