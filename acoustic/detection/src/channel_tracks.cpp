// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_tracks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "channel_model.hpp"
#include "tracking/tracking_model.hpp"
#include "whitening/decimate.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::array<double, 3> kBandRates_hz{0.0, 4e3, 1e3};  // sampling rates; the first as recorded

double rise_of_all(const BandOfChannel& band) {
  double sum = 0.0;
  for (const Candidate& candidate : band.candidates) sum += rise(candidate);
  return sum;
}

bool are_clear(const BandOfChannel& band, const ChannelTracks& found) {
  for (const Track& track : found.tracks)
    for (const TrackImpact& impact : track.impacts)
      if (rise(band.candidates[impact.candidate]) < kChannels.clear_rise) return false;
  return rise_of_impacts(band, found) > kChannels.explained * rise_of_all(band);
}

double duration_s(const BandOfChannel& band) { return static_cast<double>(band.sound.n_samples) / band.sound.rate_hz; }

double begin_s(const BandOfChannel& band, const Track& track) {
  return band.candidates[track.impacts.front().candidate].t_s;
}
double end_s(const BandOfChannel& band, const Track& track) {
  return band.candidates[track.impacts.back().candidate].t_s;
}

/// The candidate nearest to another band's, where one is within their reach and none before `first`.
std::optional<std::size_t> same_rise(const std::vector<Candidate>& candidates, const Candidate& of, std::size_t first) {
  constexpr double kLongestReach_s = 60e-3;  // the longest window, at 1 kHz
  const auto begin = std::partition_point(candidates.begin() + static_cast<std::ptrdiff_t>(first), candidates.end(),
                                          [&](const Candidate& c) { return c.t_s < of.t_s - kLongestReach_s; });
  std::optional<std::size_t> nearest;
  for (auto k = static_cast<std::size_t>(begin - candidates.begin());
       k < candidates.size() && candidates[k].t_s < of.t_s + kLongestReach_s; ++k) {
    const double off_s = std::abs(candidates[k].t_s - of.t_s);
    if (off_s < std::max(candidates[k].reach_s, of.reach_s) &&
        (!nearest || off_s < std::abs(candidates[*nearest].t_s - of.t_s)))
      nearest = k;
  }
  return nearest;
}

/// Another band's track, by the rises of its impacts in this band; those that do not rise here are left out.
Track track_in(const BandOfChannel& band, const BandOfChannel& other, const Track& track) {
  Track found{{}, track.log_odds};
  std::size_t first_free = 0;
  for (TrackImpact impact : track.impacts)
    if (const auto rise = same_rise(band.candidates, other.candidates[impact.candidate], first_free)) {
      impact.candidate = *rise;
      first_free = *rise + 1;
      found.impacts.push_back(impact);
    }
  if (found.impacts.empty()) return found;
  const std::int64_t first = found.impacts.front().impact;
  for (TrackImpact& impact : found.impacts) impact.impact -= first;
  return found;
}

/// Adds the drops that only another band shows: which band has the most of a recording says nothing of one drop.
void add_drops_of_other_bands(BandsOfChannel& bands, ChannelTracks& best) {
  const BandOfChannel& band = bands[best.band];
  std::vector<Track> more;
  for (const ChannelTracks::OfBand& other : best.others)
    for (const Track& track : other.tracks)
      if (other.band != best.band && track.log_odds > (other.band > 0 ? kTracking.lower_band : 0.0))
        more.push_back(track_in(band, bands[other.band], track));
  std::stable_sort(more.begin(), more.end(), [](const Track& a, const Track& b) { return a.log_odds > b.log_odds; });
  for (Track& track : more) {
    if (std::ssize(track.impacts) < kFewestImpacts) continue;
    const bool overlaps = std::any_of(best.tracks.begin(), best.tracks.end(), [&](const Track& other) {
      return begin_s(band, other) <= end_s(band, track) && end_s(band, other) >= begin_s(band, track);
    });
    if (!overlaps) best.tracks.push_back(std::move(track));
  }
  std::sort(best.tracks.begin(), best.tracks.end(),
            [&](const Track& a, const Track& b) { return begin_s(band, a) < begin_s(band, b); });
}

/// Where sound breaks off or begins again for want of it nothing struck.
void leave_out_edges(const std::vector<audio::Silence>& silences, CandidatesOfSound& found) {
  if (silences.empty()) return;
  CandidatesOfSound kept;
  for (std::size_t k = 0; k < found.candidates.size(); ++k) {
    const double t_s = found.candidates[k].t_s;
    if (std::any_of(silences.begin(), silences.end(), [&](const audio::Silence& gap) {
          return t_s > gap.begin_s - kChannels.edge_s && t_s < gap.end_s + kChannels.edge_s;
        }))
      continue;
    kept.candidates.push_back(found.candidates[k]);
    kept.band_energies.push_back(found.band_energies[k]);
  }
  found = std::move(kept);
}

}  // namespace

BandsOfChannel::BandsOfChannel(audio::AudioSource sound, int n_threads, ProgressCallback progress)
    : n_threads_(n_threads), progress_(std::move(progress)) {
  for (const double rate_hz : kBandRates_hz) {
    const int decimation = rate_hz > 0.0 ? static_cast<int>(sound.rate_hz / rate_hz) : 1;
    if (rate_hz == 0.0 || decimation >= 2) decimations_.push_back(decimation);
  }
  bands_.resize(decimations_.size());
  sounds_.resize(decimations_.size());
  sounds_[0] = std::move(sound);
}

BandsOfChannel::BandsOfChannel(std::vector<BandOfChannel> searched) {
  for (BandOfChannel& band : searched) bands_.emplace_back(std::move(band));
}

BandOfChannel& BandsOfChannel::operator[](std::size_t b) {
  if (bands_[b]) return *bands_[b];
  BandOfChannel& band = bands_[b].emplace();
  band.decimation = decimations_[b];
  band.sound = sound_of(b);
  if (b == 0 && progress_) progress_(0.0, duration_s(band));
  band.models = learn_ar_models(band.sound, kArOrder);
  CandidatesOfSound found = find_candidates(band.sound, band.models.signal, n_threads_, progress_);
  leave_out_edges(band.sound.silences, found);
  band.candidates = std::move(found.candidates);
  band.same_source = SameSource(found.band_energies);
  return band;
}

const audio::AudioSource& BandsOfChannel::sound_of(std::size_t b) {
  if (sounds_[b]) return *sounds_[b];
  // from the band above where its rate allows: most of a filter's time goes at the highest rate
  const bool is_of_above = b > 0 && decimations_[b] % decimations_[b - 1] == 0;
  const audio::AudioSource& above = is_of_above ? sound_of(b - 1) : *sounds_[0];
  return sounds_[b].emplace(decimate(above, decimations_[b] / (is_of_above ? decimations_[b - 1] : 1)));
}

double ChannelTracks::log_odds() const {
  double sum = 0.0;
  for (const Track& track : tracks) sum += track.log_odds;
  return sum;
}

ChannelTracks find_tracks_in(BandsOfChannel& bands) {
  ChannelTracks best;
  std::vector<ChannelTracks::OfBand> others;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const BandOfChannel& band = bands[b];
    ChannelTracks of_band{
        b, find_tracks(band.candidates, 2.0 / band.sound.rate_hz, band.same_source, duration_s(band)), {}};
    of_band.is_clear = b == 0 && are_clear(band, of_band);
    if (b == 0 || of_band.log_odds() > best.log_odds() + kTracking.lower_band) std::swap(best, of_band);
    if (!of_band.tracks.empty()) others.push_back({of_band.band, std::move(of_band.tracks)});
    if (best.is_clear) break;
  }
  best.others = std::move(others);
  add_drops_of_other_bands(bands, best);
  return best;
}

std::optional<SecondBall> second_ball(const BandOfChannel& band, const std::vector<Track>& tracks) {
  std::vector<double> impacts_s;
  for (const Track& track : tracks)
    for (const TrackImpact& impact : track.impacts) impacts_s.push_back(band.candidates[impact.candidate].t_s);
  std::sort(impacts_s.begin(), impacts_s.end());
  const auto is_of_impact = [&](double t_s) {
    const auto next = std::upper_bound(impacts_s.begin(), impacts_s.end(), t_s + kChannels.codec_noise_s);
    return next != impacts_s.begin() && t_s < *(next - 1) + kTracking.echo_s;
  };
  // an echo follows each impact by the same time
  const auto is_echo = [&](const Track& track, const std::vector<Candidate>& of) {
    double least_s = HUGE_VAL, most_s = 0.0;
    for (const TrackImpact& impact : track.impacts) {
      const double t_s = of[impact.candidate].t_s;
      const auto next = std::upper_bound(impacts_s.begin(), impacts_s.end(), t_s);
      const double delay_s = next == impacts_s.begin() ? HUGE_VAL : t_s - *(next - 1);
      least_s = std::min(least_s, delay_s);
      most_s = std::max(most_s, delay_s);
    }
    return most_s - least_s < kChannels.same_echo_s;
  };
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < band.candidates.size(); ++k)
    if (!is_of_impact(band.candidates[k].t_s)) left.push_back(k);
  if (static_cast<std::int64_t>(left.size()) < kFewestImpacts) return std::nullopt;
  std::vector<Candidate> candidates;
  for (const std::size_t k : left) candidates.push_back(band.candidates[k]);
  std::optional<SecondBall> second;
  double most = log(10.0);
  for (const Track& track :
       find_tracks(candidates, 2.0 / band.sound.rate_hz, band.same_source.of(left), duration_s(band))) {
    const double begin_s = candidates[track.impacts.front().candidate].t_s;
    const double end_s = candidates[track.impacts.back().candidate].t_s;
    const bool overlaps = std::any_of(tracks.begin(), tracks.end(), [&](const Track& other) {
      return band.candidates[other.impacts.front().candidate].t_s < end_s &&
             band.candidates[other.impacts.back().candidate].t_s > begin_s;
    });
    if (!overlaps || track.log_odds < most || is_echo(track, candidates)) continue;
    most = track.log_odds;
    second = SecondBall{begin_s, track.impacts.size()};
  }
  return second;
}

double rise_of_impacts(const BandOfChannel& band, const ChannelTracks& found) {
  double sum = 0.0;
  for (const Track& track : found.tracks)
    for (const TrackImpact& impact : track.impacts) sum += rise(band.candidates[impact.candidate]);
  return sum;
}

}  // namespace bouncelab::detection
