// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/parallel.hpp"
#include "channel_tracks.hpp"

namespace bouncelab::detection {

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
ChosenChannel choose_channel(const std::vector<audio::AudioSource>& channels, int n_threads,
                             const ProgressCallback& progress);

/// Whether one channel is to be preferred to another: the one of the more probable tracks; where both have recorded the
/// same ball, the one in which its impacts rise the more, since that makes their times accurate.
bool is_preferred(const BandOfChannel& band, const ChannelTracks& found, const BandOfChannel& other_band,
                  const ChannelTracks& other);

}  // namespace bouncelab::detection
