// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_tracks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bouncelab/audio/dsp/decimate.hpp"
#include "tracking/first_arrivals.hpp"

namespace bouncelab::detection {
namespace {

// enough poles for the strongest twenty-odd modes of a plate; more gain nothing in noise
constexpr int kArOrder = 48;
constexpr std::array<double, 3> kBandRates_hz{0.0, 4e3, 1e3};  // sampling rates; the first as recorded

// log odds by which a lower band must win: the best of three is chosen, and low bands give less accurate times
constexpr double kBandSelectionMargin = 1.5;

constexpr double kSameBall = 0.25;  // share of their log odds by which channels with the same impacts differ

/// Of all impacts.
double log_likelihood_ratio(const BandOfChannel& band, const ChannelTracks& found) {
  double sum = 0.0;
  for (const Track& track : found.tracks)
    for (const TrackImpact& impact : track.impacts) sum += band.candidates[impact.candidate].log_likelihood_ratio;
  return sum;
}

}  // namespace

std::vector<BandOfChannel> bands_of(const audio::AudioSource& sound, const ProgressCallback& progress) {
  std::vector<BandOfChannel> bands;
  for (const double rate_hz : kBandRates_hz) {
    const int factor = rate_hz > 0.0 ? static_cast<int>(sound.rate_hz / rate_hz) : 1;
    if (rate_hz > 0.0 && factor < 2) continue;
    BandOfChannel band;
    band.sound = factor > 1 ? audio::decimate(sound, factor) : sound;
    band.decimation = factor;
    band.models = audio::learn_ar_models(band.sound, kArOrder);
    band.candidates = find_candidates(band.sound, band.models.signal, progress);
    band.band_energies = measure_band_energies(band.sound, band.candidates);
    bands.push_back(std::move(band));
  }
  return bands;
}

double ChannelTracks::log_odds() const {
  double sum = 0.0;
  for (const Track& track : tracks) sum += track.log_odds;
  return sum;
}

ChannelTracks find_tracks_in(const std::vector<BandOfChannel>& bands, const TrackingModel& model) {
  ChannelTracks best;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const BandOfChannel& band = bands[b];
    ChannelTracks here{b, find_tracks(band.candidates, 2.0 / band.sound.rate_hz, band.band_energies, model)};
    begin_at_first_arrivals(band.candidates, here.tracks);
    if (b == 0 || here.log_odds() > best.log_odds() + kBandSelectionMargin) best = std::move(here);
  }
  return best;
}

bool is_preferred(const BandOfChannel& band, const ChannelTracks& found, const BandOfChannel& other_band,
                  const ChannelTracks& other) {
  const double most = std::max(found.log_odds(), other.log_odds());
  if (std::abs(found.log_odds() - other.log_odds()) > kSameBall * most) return found.log_odds() > other.log_odds();
  return log_likelihood_ratio(band, found) > log_likelihood_ratio(other_band, other);
}

}  // namespace bouncelab::detection
