// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_choice.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "bouncelab/core/parallel.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kSameBall = 0.25;  // share of their log odds by which channels with the same impacts differ

// A look at a channel: places evenly over it, and impacts of another channel
constexpr double kPlacesApart_s = 1.0;
constexpr std::size_t kMostPlaces = 32;
constexpr std::size_t kMostImpacts = 16;
constexpr double kAroundPlace_s = 20e-3;
constexpr double kAroundImpact_s = 5e-3;  // sound takes 3 ms from one microphone to another that is a metre farther off
// A channel whose impacts rise by less than that is not searched. Of sound that rises by 30 dB it is 0.4 dB, a
// twentieth of the standard errors of times
constexpr double kNoMore = 1.02;

/// How much a channel rises around some times, which are in ascending order.
double rise_near(const audio::AudioSource& sound, const ArModel& model, const std::vector<double>& t_s,
                 double within_s) {
  const std::vector<double> rises = highest_rises(sound, model, t_s, within_s);
  return std::accumulate(rises.begin(), rises.end(), 0.0);
}

/// At places that lie evenly over the channel.
double rise_at_places(const audio::AudioSource& sound, const ArModel& model) {
  const double duration_s = static_cast<double>(sound.n_samples) / sound.rate_hz;
  const auto n = std::clamp<std::size_t>(static_cast<std::size_t>(duration_s / kPlacesApart_s), 1, kMostPlaces);
  std::vector<double> t_s(n);
  for (std::size_t k = 0; k < n; ++k) t_s[k] = duration_s * (static_cast<double>(k) + 0.5) / static_cast<double>(n);
  return rise_near(sound, model, t_s, kAroundPlace_s);
}

/// Times of some of the impacts, evenly over them.
std::vector<double> some_impacts_s(const ChosenChannel& of) {
  std::vector<double> all_s;
  for (const Track& track : of.found.tracks)
    for (const TrackImpact& impact : track.impacts) all_s.push_back(of.band.candidates[impact.candidate].t_s);
  std::sort(all_s.begin(), all_s.end());  // tracks may overlap
  std::vector<double> some_s(std::min(all_s.size(), kMostImpacts));
  for (std::size_t k = 0; k < some_s.size(); ++k) some_s[k] = all_s[k * all_s.size() / some_s.size()];
  return some_s;
}

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

bool is_better(const ChosenChannel& a, const ChosenChannel& b) {
  if (is_preferred(a.band, a.found, b.band, b.found)) return true;
  return a.channel < b.channel && !is_preferred(b.band, b.found, a.band, a.found);
}

}  // namespace

ChosenChannel choose_channel(const std::vector<audio::AudioSource>& channels, int n_threads,
                             const ProgressCallback& progress) {
  const auto search = [&](std::size_t c) { return searched(BandsOfChannel(channels[c], n_threads, progress), c); };
  if (channels.size() == 1) return search(0);
  std::vector<ArModel> models(channels.size());
  std::vector<double> rises(channels.size());
  parallel_for(channels.size(), n_threads, [&](std::size_t c) {
    models[c] = learn_ar_models(channels[c], kArOrder).signal;
    rises[c] = rise_at_places(channels[c], models[c]);
  });
  std::optional<ChosenChannel> best;
  std::vector<double> impacts_s;  // of the best
  const auto rise_of_impacts_in = [&](std::size_t c) {
    return rise_near(channels[c], models[c], impacts_s, kAroundImpact_s);
  };
  double most_of_impacts = 0.0;  // rise of them in it
  for (std::size_t n = 0; n < channels.size(); ++n) {
    const auto most = std::max_element(rises.begin(), rises.end());  // of equal ones the first
    const auto c = static_cast<std::size_t>(most - rises.begin());
    *most = -1.0;
    if (best && best->found.is_clear && rise_of_impacts_in(c) <= kNoMore * most_of_impacts) continue;
    ChosenChannel next = search(c);
    if (best && !is_better(next, *best)) continue;
    best = std::move(next);
    impacts_s = some_impacts_s(*best);
    most_of_impacts = rise_of_impacts_in(c);
  }
  return *std::move(best);
}

bool is_preferred(const BandOfChannel& band, const ChannelTracks& found, const BandOfChannel& other_band,
                  const ChannelTracks& other) {
  const double most = std::max(found.log_odds(), other.log_odds());
  if (std::abs(found.log_odds() - other.log_odds()) > kSameBall * most) return found.log_odds() > other.log_odds();
  return rise_of_impacts(band, found) > rise_of_impacts(other_band, other);
}

}  // namespace bouncelab::detection
