// SPDX-License-Identifier: GPL-3.0-or-later
#include "channel_tracks.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "tracking/tracking_model.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::array<double, 2> kLowRates_hz{4e3, 1e3};
constexpr float kLeastShare = 0.1F;  // of what is compared, that is no noise

/// How much all impacts of the tracks rise in a band.
double rise_of_impacts(const BandOfChannel& band, const ChannelTracks& found) {
  double sum = 0.0;
  for (const Track& track : found.tracks)
    for (const TrackImpact& impact : track.impacts) sum += rise(band.candidates[impact.candidate]);
  return sum;
}

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

/// The largest normalised correlation of the innovations after two candidates, within the reach of both; of what is
/// above the noise, which is like nothing. May be above 1, where that is little.
double likeness_of(const BandOfChannel& band, const Candidate& a, const Candidate& b) {
  const double rate_hz = band.sound.rate_hz;
  const std::int64_t n = kChannels.n_compared;
  const auto most_lag = static_cast<std::int64_t>(std::ceil(std::max(a.reach_s, b.reach_s) * rate_hz));
  const auto innovations = [&](double t_s, std::int64_t before, std::int64_t n_samples) {
    Eigen::ArrayXf u(n_samples);
    read_innovations(band.sound, band.models.signal, std::llround(t_s * rate_hz) - before,
                     {u.data(), static_cast<std::size_t>(n_samples)});
    return u;
  };
  const auto noise = static_cast<float>(band.models.signal.quiet_variance) * static_cast<float>(n);
  const auto energy = [&](float with_noise) { return std::max(with_noise - noise, kLeastShare * with_noise); };
  const Eigen::ArrayXf first = innovations(a.t_s, 0, n);
  const Eigen::ArrayXf second = innovations(b.t_s, most_lag, n + 2 * most_lag);
  const float of_first = energy(first.square().sum());
  float largest = 0.0F;
  for (std::int64_t lag = 0; lag <= 2 * most_lag; ++lag) {
    const auto shifted = second.segment(lag, n);
    largest = std::max(largest, (first * shifted).sum() / std::sqrt(of_first * energy(shifted.square().sum())));
  }
  return largest;
}

/// In a lower band: above 2 kHz the impacts of a real ball are no more alike than other sounds, since each strikes
/// another place.
/// @param candidates  of this band or another
Likeness likeness_in(const BandOfChannel& band, const std::vector<Candidate>& candidates) {
  return [&](std::size_t j, std::size_t k) { return likeness_of(band, candidates[j], candidates[k]); };
}

double begin_s(const std::vector<Candidate>& c, const Track& track) { return c[track.impacts.front().candidate].t_s; }
double end_s(const std::vector<Candidate>& c, const Track& track) { return c[track.impacts.back().candidate].t_s; }

/// Whether one of the tracks goes on while another does, of candidates that may be others.
bool is_any_during(const std::vector<Candidate>& c, const std::vector<Track>& tracks,
                   const std::vector<Candidate>& of_other, const Track& other) {
  return std::any_of(tracks.begin(), tracks.end(), [&](const Track& track) {
    return begin_s(c, track) <= end_s(of_other, other) && end_s(c, track) >= begin_s(of_other, other);
  });
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
    if (!is_any_during(band.candidates, best.tracks, band.candidates, track)) best.tracks.push_back(std::move(track));
  }
  std::sort(best.tracks.begin(), best.tracks.end(),
            [&](const Track& a, const Track& b) { return begin_s(band.candidates, a) < begin_s(band.candidates, b); });
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

ChosenChannel searched(BandsOfChannel bands, std::size_t channel) {
  ChannelTracks found = find_tracks_in(bands);
  ChosenChannel chosen{channel, std::move(bands[found.band]), {}, {}};
  chosen.band.same_source = {};  // an hour of dense music has twenty megabytes of it
  for (const ChannelTracks::OfBand& other : found.others) {
    chosen.other_bands.push_back(std::move(bands[other.band]));
    chosen.other_bands.back().same_source = {};
  }
  chosen.found = std::move(found);
  return chosen;
}

}  // namespace

BandsOfChannel::BandsOfChannel(audio::AudioSource sound, int n_threads, ProgressCallback progress,
                               std::optional<double> elastic_flight_s)
    : n_threads_(n_threads), progress_(std::move(progress)) {
  bands_.emplace_back().sound = std::move(sound);
  for (const double rate_hz : kLowRates_hz)
    if (const auto decimation = static_cast<int>(bands_[0].sound.rate_hz / rate_hz); decimation >= 2)
      bands_.emplace_back().decimation = decimation;
  for (BandOfChannel& band : bands_) band.elastic_flight_s = elastic_flight_s;
}

BandsOfChannel::BandsOfChannel(std::vector<BandOfChannel> searched)
    : bands_(std::move(searched)), n_searched_(bands_.size()) {}

BandOfChannel& BandsOfChannel::operator[](std::size_t b) {
  for (; n_searched_ <= b; ++n_searched_) search(n_searched_);
  return bands_[b];
}

void BandsOfChannel::search(std::size_t b) {
  BandOfChannel& band = bands_[b];
  if (b > 0) {
    // from the band above where its rate allows: most of a filter's time goes at the highest rate
    const BandOfChannel& above = bands_[band.decimation % bands_[b - 1].decimation == 0 ? b - 1 : 0];
    band.sound = decimate(above.sound, band.decimation / above.decimation);
  }
  if (b == 0 && progress_) progress_(0.0, duration_s(band));
  band.models = learn_ar_models(band.sound, kArOrder);
  CandidatesOfSound found = find_candidates(band.sound, band.models.signal, n_threads_, progress_);
  leave_out_edges(band.sound.silences, found);
  band.candidates = std::move(found.candidates);
  band.same_source = SameSource(found.band_energies);
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
    ChannelTracks of_band{b,
                          find_tracks(band.candidates, 2.0 / band.sound.rate_hz, band.same_source, duration_s(band),
                                      band.elastic_flight_s, b > 0 ? likeness_in(band, band.candidates) : Likeness()),
                          {}};
    of_band.is_clear = b == 0 && are_clear(band, of_band);
    if (b > 0) {
      // tracks of the whole band sound as much alike in this one
      double alike = 0.0;
      if (best.band == 0)
        for (const Track& track : best.tracks)
          alike += log_odds_of_likeness(track, likeness_in(band, bands[0].candidates));
      if (of_band.log_odds() > best.log_odds() + alike + kTracking.lower_band) std::swap(best, of_band);
    } else
      std::swap(best, of_band);
    if (!of_band.tracks.empty()) others.push_back({of_band.band, std::move(of_band.tracks)});
    if (best.is_clear) break;
  }
  best.others = std::move(others);
  add_drops_of_other_bands(bands, best);
  return best;
}

ChosenChannel choose_channel(std::span<const audio::AudioSource> channels, int n_threads,
                             const ProgressCallback& progress, std::optional<double> elastic_flight_s) {
  ChosenChannel best = searched(BandsOfChannel(channels[0], n_threads, progress, elastic_flight_s), 0);
  for (std::size_t c = 1; c < channels.size(); ++c) {
    ChosenChannel next = searched(BandsOfChannel(channels[c], n_threads, progress, elastic_flight_s), c);
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
