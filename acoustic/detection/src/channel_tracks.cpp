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
double rise_of_impacts(const BandOfChannel& band) {
  double sum = 0.0;
  for (const Track& track : band.tracks)
    for (const TrackImpact& impact : track.impacts) sum += rise(band.candidates[impact.candidate]);
  return sum;
}

double rise_of_all(const BandOfChannel& band) {
  double sum = 0.0;
  for (const Candidate& candidate : band.candidates) sum += rise(candidate);
  return sum;
}

bool are_clear(const BandOfChannel& band) {
  for (const Track& track : band.tracks)
    for (const TrackImpact& impact : track.impacts)
      if (rise(band.candidates[impact.candidate]) < kChannels.clear_rise) return false;
  return rise_of_impacts(band) > kChannels.explained * rise_of_all(band);
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

double BandOfChannel::log_odds() const {
  double sum = 0.0;
  for (const Track& track : tracks) sum += track.log_odds;
  return sum;
}

std::vector<BandOfChannel> bands_of(audio::AudioSource sound) {
  std::vector<BandOfChannel> bands;
  for (const double rate_hz : kLowRates_hz)
    if (const auto decimation = static_cast<int>(sound.rate_hz / rate_hz); decimation >= 2)
      bands.push_back({.decimation = decimation});
  bands.insert(bands.begin(), BandOfChannel{.sound = std::move(sound)});
  return bands;
}

void find_candidates_of(std::vector<BandOfChannel>& bands, std::size_t b, int n_threads,
                        const ProgressCallback& progress) {
  BandOfChannel& band = bands[b];
  if (b > 0) {
    // from the band above where its rate allows: most of a filter's time goes at the highest rate
    const BandOfChannel& above = bands[band.decimation % bands[b - 1].decimation == 0 ? b - 1 : 0];
    band.sound = decimate(above.sound, band.decimation / above.decimation);
  }
  if (b == 0 && progress) progress(0.0, duration_s(band));
  band.models = learn_ar_models(band.sound, kArOrder);
  CandidatesOfSound found = find_candidates(band.sound, band.models.signal, n_threads, progress);
  leave_out_edges(band.sound.silences, found);
  band.candidates = std::move(found.candidates);
  band.same_source = SameSource(found.band_energies);
}

SearchedChannel search_channel(std::vector<BandOfChannel> bands, std::optional<double> elastic_flight_s, int n_threads,
                               const ProgressCallback& progress) {
  std::size_t best = 0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    BandOfChannel& band = bands[b];
    if (band.models.signal.filter.empty()) find_candidates_of(bands, b, n_threads, progress);
    band.tracks = find_tracks(band.candidates, 2.0 / band.sound.rate_hz, band.same_source, duration_s(band),
                              elastic_flight_s, b > 0 ? likeness_in(band, band.candidates) : Likeness());
    if (b == 0) {
      if (are_clear(band)) break;
      continue;
    }
    double least = bands[best].log_odds() + kTracking.lower_band;
    if (best == 0)  // tracks of the whole band sound as much alike in this one
      for (const Track& track : bands[0].tracks)
        least += log_odds_of_likeness(track, likeness_in(band, bands[0].candidates));
    if (band.log_odds() > least) best = b;
  }
  for (BandOfChannel& band : bands) band.same_source = {};  // an hour of dense music has twenty megabytes of it
  return {0, std::move(bands), best};
}

SearchedChannel choose_channel(std::span<const audio::AudioSource> channels, std::optional<double> elastic_flight_s,
                               int n_threads, const ProgressCallback& progress) {
  SearchedChannel best;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    SearchedChannel next = search_channel(bands_of(channels[c]), elastic_flight_s, n_threads, progress);
    next.channel = c;
    if (c == 0 || is_preferred(next.bands[next.best], best.bands[best.best])) best = std::move(next);
  }
  return best;
}

bool is_preferred(const BandOfChannel& band, const BandOfChannel& other) {
  const double most = std::max(band.log_odds(), other.log_odds());
  if (std::abs(band.log_odds() - other.log_odds()) > kChannels.same_ball * most)
    return band.log_odds() > other.log_odds();
  return rise_of_impacts(band) > rise_of_impacts(other);
}

}  // namespace bouncelab::detection
