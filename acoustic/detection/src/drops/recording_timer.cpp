// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/recording_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "contact/contact_time.hpp"
#include "drops/drops_model.hpp"
#include "drops/other_bands.hpp"
#include "tracking/impact_odds.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {
namespace {

/// Where the next track begins, or the recording ends.
double end_of_track(const BandOfDrops& band, std::size_t k) {
  return k + 1 < band.tracks.size() ? band.candidates[band.tracks[k + 1].impacts.front().candidate].t_s
                                    : static_cast<double>(band.sound.n_samples) / band.sound.rate_hz;
}

struct TimedDrops {
  bool is_full_band = true;
  double noise_variance = 0.0;  // in it
  std::vector<TimedDrop> drops;

  /// Of the impacts as recorded, by the first template; absent without template.
  std::optional<double> rms_hz() const {
    const auto first = std::find_if(drops.begin(), drops.end(), [](const TimedDrop& drop) { return drop.rms_hz; });
    return first == drops.end() ? std::nullopt : first->rms_hz;
  }
};

/// Times each track by itself, on several threads.
TimedDrops time_tracks(const BandOfDrops& band, double gravity_mps2, int n_threads) {
  std::optional<ImpactTemplate> shared;  // of the tracks that have none of their own
  if (std::any_of(band.tracks.begin(), band.tracks.end(),
                  [](const Track& track) { return track.impacts.size() < kDrops.own_template; })) {
    WhiteSound white(band.sound);
    shared = template_of(band, band.tracks, white);
  }
  TimedDrops timed{!band.whole, band.noise.quiet_variance, std::vector<TimedDrop>(band.tracks.size())};
  parallel_for(band.tracks.size(), n_threads, [&](std::size_t k) {
    const Track& track = band.tracks[k];
    WhiteSound white(band.sound);
    const std::optional<ImpactTemplate> own =
        track.impacts.size() >= kDrops.own_template ? template_of(band, {track}, white) : std::nullopt;
    const ImpactTemplate* learned = own ? &*own : shared ? &*shared : nullptr;
    timed.drops[k] = time_drop(band, track, learned, end_of_track(band, k), gravity_mps2, white);
  });
  return timed;
}

/// The contact-time law of all drops; absent without template.
std::optional<ContactLaw> contact_law_of(const TimedDrops& timed) {
  const std::optional<double> rms_hz = timed.rms_hz();
  if (!rms_hz) return std::nullopt;
  std::vector<ContactEvidence> evidence;
  for (const TimedDrop& drop : timed.drops)
    if (drop.contact) evidence.push_back(*drop.contact);
  return pool_contacts(evidence, assumed_contact(*rms_hz));
}

/// Median standard error of all impacts.
double median_sigma_s(const TimedDrops& timed) {
  std::vector<double> sigma_s;
  for (const TimedDrop& drop : timed.drops)
    for (const TimedImpact& impact : drop.impacts) sigma_s.push_back(hypot(impact.fit.sigma_s, impact.doubt_s));
  return sigma_s.empty() ? INFINITY : upper_median(std::move(sigma_s));
}

std::size_t n_impacts(const TimedDrops& timed) {
  std::size_t n = 0;
  for (const TimedDrop& drop : timed.drops) n += drop.impacts.size();
  return n;
}

BandOfDrops in_whole_sound(const BandOfDrops& band) {
  BandOfDrops whole = band;
  whole.sound = *band.whole;
  whole.whole.reset();
  whole.noise = learn_ar_models(whole.sound, static_cast<int>(band.noise.filter.size()) - 2).noise;
  return whole;
}

BandOfDrops with_rms_hz(BandOfDrops band, std::optional<double> rms_hz) {
  if (band.whole) band.recorded_rms_hz = rms_hz;
  return band;
}

double first_s(const TimedDrop& drop) { return drop.impacts.front().fit.t_s; }
double last_s(const TimedDrop& drop) { return drop.impacts.back().fit.t_s; }

/// Adds to each drop what another band shows of it.
void add_drops_of_other_band(const BandOfDrops& band, double gravity_mps2, const TimedDrops& other, TimedDrops& timed) {
  std::vector<TimedDrop>& drops = timed.drops;
  for (std::size_t k = 0; k < drops.size(); ++k) {
    TimedDrop& drop = drops[k];
    const double begin_s = k == 0 ? -INFINITY : last_s(drops[k - 1]);
    const double end_s = k + 1 == drops.size() ? INFINITY : first_s(drops[k + 1]);
    std::size_t n_added = 0;
    for (const TimedDrop& shown : other.drops)
      if (first_s(shown) < last_s(drop) && last_s(shown) > first_s(drop))
        n_added += add_impacts_of_other_band(shown, begin_s, end_s, drop);
    if (n_added == 0) continue;
    set_speeds(gravity_mps2, drop.impacts);
    mark_clipped(band, drop.impacts);
  }
}

/// Tracks that another band shows at the time of those that were selected.
std::vector<Track> tracks_at_those_of(const BandOfDrops& band, const BandOfDrops& other) {
  const auto time = [](const BandOfDrops& of, const TrackImpact& impact) {
    return of.candidates[impact.candidate].t_s;
  };
  std::vector<Track> found;
  for (const Track& shown : other.tracks)
    if (std::any_of(band.tracks.begin(), band.tracks.end(), [&](const Track& selected) {
          return time(band, selected.impacts.front()) < time(other, shown.impacts.back()) &&
                 time(band, selected.impacts.back()) > time(other, shown.impacts.front());
        }))
      found.push_back(shown);
  return found;
}

/// In the best band, with what others add.
///
/// A band in which impacts stand out from clutter need not be the one that times them best: low frequencies hold little
/// of the information. Times them in the whole sound too, and takes that where no impact is lost and the errors are
/// half as large: the lesser of two estimated errors is too small by chance.
TimedDrops time_drops(const BandOfDrops& band, const std::vector<BandOfDrops>& other_bands, double gravity_mps2,
                      int n_threads) {
  TimedDrops best = time_tracks(band.whole ? in_whole_sound(band) : band, gravity_mps2, n_threads);
  const std::optional<double> rms_hz = best.rms_hz();
  std::optional<TimedDrops> second;  // of the two, where the band is not the whole sound
  if (band.whole) {
    second = time_tracks(with_rms_hz(band, rms_hz), gravity_mps2, n_threads);
    const bool whole_is_better =
        n_impacts(best) >= n_impacts(*second) && median_sigma_s(best) < kDrops.clearly_less * median_sigma_s(*second);
    if (!whole_is_better) std::swap(best, *second);
  }
  for (const BandOfDrops& other : other_bands) {
    BandOfDrops shown = with_rms_hz(other, rms_hz);
    shown.tracks = tracks_at_those_of(band, other);
    if (!shown.tracks.empty())
      add_drops_of_other_band(band, gravity_mps2, time_tracks(shown, gravity_mps2, n_threads), best);
  }
  if (second) add_drops_of_other_band(band, gravity_mps2, *second, best);
  return best;
}

/// What takes the time of an impact to the start of contact.
struct ContactCorrection {
  double delay_s = 0.0;
  double sigma_s = 0.0;
};

/// An error of the law moves all impacts of a drop alike but for the differences in speed: what it does to an interval
/// is the part of it that enters the standard error.
ContactCorrection contact_correction(const ContactLaw& law, const TimedDrop& drop, std::size_t k) {
  const std::vector<TimedImpact>& impacts = drop.impacts;
  if (!(impacts[k].v_mps > 0.0)) return {};
  const auto delay = [&](std::size_t j) { return contact_delay(impacts[j].v_mps, drop.reference_scaling); };
  double against_neighbours = 0.0;
  for (const std::size_t j : {k - 1, k + 1})
    if (j < impacts.size() && impacts[j].v_mps > 0.0)
      against_neighbours = std::max(against_neighbours, std::abs(delay(k) - delay(j)));
  return {delay(k) * law.tau_1_s, against_neighbours * law.sigma_s};
}

Onset to_onset(const TimedImpact& from, double log_odds_of_track, const ContactCorrection& contact,
               std::optional<double> peak, double noise_variance) {
  Onset onset;
  onset.impact = from.impact;
  onset.t_s = from.fit.t_s - contact.delay_s;
  onset.sigma_t_s = hypot(hypot(from.fit.sigma_s, from.doubt_s), contact.sigma_s);
  // a doubtful impact may fit best upside down: then its amplitude is not known
  if (peak && from.fit.amplitude > 0.0) {
    onset.amplitude = from.fit.amplitude * *peak;
    if (noise_variance > 0.0) onset.snr_db = 20.0 * log10(*onset.amplitude / std::sqrt(noise_variance));
  }
  onset.probability = probability_of_mark(log_odds_of_track, from.probability);
  if (from.clipped) onset.flags.add(Flag::clipped);
  if (from.overlap) onset.flags.add(Flag::overlap);
  if (from.inferred) onset.flags.add(Flag::inferred);
  if (*onset.probability < 0.5) onset.flags.add(Flag::improbable);
  if (from.doubtful) onset.flags.add(Flag::doubtful);
  return onset;
}

}  // namespace

TimedRecording time_recording(const BandOfDrops& band, const std::vector<BandOfDrops>& other_bands, double gravity_mps2,
                              int n_threads, const std::string& name) {
  TimedRecording recording;
  const TimedDrops timed = time_drops(band, other_bands, gravity_mps2, n_threads);
  recording.is_full_band = timed.is_full_band;
  const std::optional<ContactLaw> law = contact_law_of(timed);
  if (law && law->is_significant) recording.contact_time_at_1_mps_s = law->tau_1_s;
  if (law) recording.contact_time_sigma_s = law->sigma_s;
  std::size_t n_longest = 0;
  for (std::size_t d = 0; d < timed.drops.size(); ++d) {
    const TimedDrop& drop = timed.drops[d];
    if (drop.wave && band.tracks[d].impacts.size() > n_longest) {
      n_longest = band.tracks[d].impacts.size();
      recording.wave = drop.wave;
    }
    for (std::size_t k = 0; k < drop.impacts.size(); ++k) {
      const ContactCorrection contact = law ? contact_correction(*law, drop, k) : ContactCorrection{};
      Onset onset = to_onset(drop.impacts[k], band.tracks[d].log_odds, contact, drop.peak, timed.noise_variance);
      onset.recording = name;
      onset.drop = static_cast<std::int64_t>(d);
      recording.onsets.push_back(std::move(onset));
    }
  }
  return recording;
}

}  // namespace bouncelab::detection
