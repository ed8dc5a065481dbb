// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_choice.hpp"
#include "channel_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bouncelab::detection {
namespace {

ChosenChannel searched(BandsOfChannel bands, std::size_t channel) {
  ChannelTracks found = find_tracks_in(bands);
  ChosenChannel chosen{channel, std::move(bands[found.band]), {}, {}};
  if (!found.tracks.empty() && !found.is_clear) found.second_ball = second_ball(chosen.band, found.tracks);
  chosen.band.same_source = {};  // an hour of dense music has twenty megabytes of it
  for (const ChannelTracks::OfBand& other : found.others) {
    chosen.other_bands.push_back(std::move(bands[other.band]));
    chosen.other_bands.back().same_source = {};
  }
  chosen.found = std::move(found);
  return chosen;
}

}  // namespace

ChosenChannel choose_channel(const std::vector<audio::AudioSource>& channels, int n_threads,
                             const ProgressCallback& progress) {
  ChosenChannel best = searched(BandsOfChannel(channels[0], n_threads, progress), 0);
  for (std::size_t c = 1; c < channels.size(); ++c) {
    ChosenChannel next = searched(BandsOfChannel(channels[c], n_threads, progress), c);
    if (is_preferred(next.band, next.found, best.band, best.found)) best = std::move(next);
  }
  return best;
}

bool is_preferred(const BandOfChannel& band, const ChannelTracks& found, const BandOfChannel& other_band,
                  const ChannelTracks& other) {
  const double most = std::max(found.log_odds(), other.log_odds());
  if (std::abs(found.log_odds() - other.log_odds()) > kChannels.same_ball * most)
    return found.log_odds() > other.log_odds();
  return rise_of_impacts(band, found) > rise_of_impacts(other_band, other);
}

}  // namespace bouncelab::detection
