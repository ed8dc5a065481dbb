// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/drop_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "contact/contact_time.hpp"
#include "delay/timed_impact.hpp"
#include "drops/template_alignment.hpp"
#include "tracking/tracker.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

using TimedImpacts = std::vector<TimedImpact>;

/// An impact that both bands show.
struct Shared {
  std::size_t own = 0, theirs = 0;
  double later_s = 0.0;  // in the own band
};

double shorter_interval(const TimedImpacts& impacts, std::size_t k) {
  const double before_s = k > 0 ? impacts[k].fit.t_s - impacts[k - 1].fit.t_s : INFINITY;
  const double after_s = k + 1 < impacts.size() ? impacts[k + 1].fit.t_s - impacts[k].fit.t_s : INFINITY;
  return std::min(before_s, after_s);
}

/// Pairs of impacts that are nearest to each other, less than a quarter of the intervals and reach_s from later_s.
std::vector<Shared> shared_impacts(const TimedImpacts& own, const TimedImpacts& theirs, double later_s,
                                   double reach_s) {
  std::vector<Shared> shared;
  std::size_t j = 0;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const auto off_s = [&](std::size_t other) { return own[k].fit.t_s - theirs[other].fit.t_s - later_s; };
    while (j + 1 < theirs.size() && std::abs(off_s(j + 1)) < std::abs(off_s(j))) ++j;
    const double most_s =
        std::min(reach_s, kDrops.same_of_interval * std::min(shorter_interval(own, k), shorter_interval(theirs, j)));
    if (std::abs(off_s(j)) > most_s || (!shared.empty() && shared.back().theirs == j)) continue;
    shared.push_back({k, j, off_s(j) + later_s});
  }
  return shared;
}

double median_later_s(const std::vector<Shared>& shared) {
  std::vector<double> later_s;
  for (const Shared& s : shared) later_s.push_back(s.later_s);
  return upper_median(std::move(later_s));
}

std::vector<Shared> shared_impacts(const TimedImpacts& own, const TimedImpacts& theirs) {
  if (own.empty() || theirs.empty()) return {};
  const std::vector<Shared> rough = shared_impacts(own, theirs, 0.0, kDrops.most_delay_s);
  if (rough.size() < kDrops.fewest_shared) return {};
  std::vector<Shared> shared = shared_impacts(own, theirs, median_later_s(rough), kDelay.least_interval_s);
  if (shared.size() < kDrops.fewest_shared || 2 * shared.size() < std::min(own.size(), theirs.size())) return {};
  return shared;
}

/// What takes an impact of the other band to this one.
struct Transfer {
  double later_s = 0.0, sigma_s = 0.0;
  double gain = 1.0;  // of the amplitude
};

/// By the shared impacts nearest to number `next`, the first after it.
Transfer transfer_at(const std::vector<Shared>& shared, std::size_t next, const TimedImpacts& own,
                     const TimedImpacts& theirs) {
  const std::size_t n = std::min(kDrops.nearest_shared, shared.size());
  const std::size_t first = std::min(next > n / 2 ? next - n / 2 : 0, shared.size() - n);
  std::vector<double> later_s, gain, off_s;
  for (std::size_t k = first; k < first + n; ++k) {
    later_s.push_back(shared[k].later_s);
    const double amplitude = theirs[shared[k].theirs].fit.amplitude;
    if (amplitude > 0.0) gain.push_back(own[shared[k].own].fit.amplitude / amplitude);
  }
  Transfer transfer;
  transfer.later_s = upper_median(later_s);
  for (const double s : later_s) off_s.push_back(std::abs(s - transfer.later_s));
  constexpr double kOfMedian = 1.2533;  // of a normal distribution
  transfer.sigma_s = kSdOverMad * kOfMedian * upper_median(std::move(off_s)) / std::sqrt(static_cast<double>(n));
  if (!gain.empty()) transfer.gain = upper_median(std::move(gain));
  return transfer;
}

/// Number of the other band's impact j in this one; absent where the shared impacts on either side disagree.
std::optional<std::int64_t> number_of(const std::vector<Shared>& shared, std::size_t next, std::size_t j,
                                      const TimedImpacts& own, const TimedImpacts& theirs) {
  const auto more = [&](std::size_t k) { return own[shared[k].own].impact - theirs[shared[k].theirs].impact; };
  const bool is_after_one = next > 0, is_before_one = next < shared.size();
  if (is_after_one && is_before_one && more(next - 1) != more(next)) return {};
  return theirs[j].impact + more(is_after_one ? next - 1 : next);
}

/// Time of one flight between two impacts of known numbers, if they are there.
double flight_s(const TimedImpacts& impacts, std::size_t before, std::size_t after) {
  if (after >= impacts.size()) return 0.0;
  return (impacts[after].fit.t_s - impacts[before].fit.t_s) /
         static_cast<double>(std::max<std::int64_t>(1, impacts[after].impact - impacts[before].impact));
}

double error_s(const TimedImpact& impact) { return hypot(impact.fit.sigma_s, impact.doubt_s); }

/// Puts it at its number, where that is free or far less is known of its time, and its neighbours are as far as its
/// flights say.
bool insert(const TimedImpact& impact, double before_s, double after_s, TimedImpacts& impacts) {
  const auto at = std::partition_point(impacts.begin(), impacts.end(),
                                       [&](const TimedImpact& other) { return other.impact < impact.impact; });
  const bool is_there = at != impacts.end() && at->impact == impact.impact;
  if (is_there && !(error_s(impact) < kDrops.clearly_less * error_s(*at))) return false;
  const auto after = is_there ? at + 1 : at;
  if (after != impacts.end() &&
      after->fit.t_s - impact.fit.t_s < std::max(kDelay.least_interval_s, kDrops.least_of_flight * after_s))
    return false;
  if (at != impacts.begin() &&
      impact.fit.t_s - (at - 1)->fit.t_s < std::max(kDelay.least_interval_s, kDrops.least_of_flight * before_s))
    return false;
  if (is_there)
    *at = impact;
  else
    impacts.insert(at, impact);
  return true;
}

/// @param may_infer  what the other band has by prediction alone is added too
std::size_t add_impacts(const TimedDrop& other, double begin_s, double end_s, bool may_infer, TimedDrop& drop) {
  const TimedImpacts& theirs = other.impacts;
  const TimedImpacts own = drop.impacts;
  const std::vector<Shared> shared = shared_impacts(own, theirs);
  if (shared.empty()) return 0;
  std::size_t n_added = 0, next = 0;
  for (std::size_t j = 0; j < theirs.size(); ++j) {
    while (next < shared.size() && shared[next].theirs < j) ++next;
    if (next < shared.size() && shared[next].theirs == j) continue;
    if (theirs[j].inferred && !may_infer) continue;
    const std::optional<std::int64_t> number = number_of(shared, next, j, own, theirs);
    if (!number) continue;
    const Transfer transfer = transfer_at(shared, next, own, theirs);
    TimedImpact impact = theirs[j];
    impact.impact = *number;
    impact.fit.t_s += transfer.later_s;
    impact.fit.sigma_s = hypot(impact.fit.sigma_s, transfer.sigma_s);
    impact.fit.amplitude *= transfer.gain;
    impact.v_mps = 0.0;
    const double before_s = j > 0 ? flight_s(theirs, j - 1, j) : 0.0, after_s = flight_s(theirs, j, j + 1);
    if (!(impact.fit.t_s - before_s > begin_s && impact.fit.t_s + after_s < end_s)) continue;
    if (insert(impact, before_s, after_s, drop.impacts)) ++n_added;
  }
  const std::int64_t first = drop.impacts.front().impact;
  if (first < 0)
    for (TimedImpact& impact : drop.impacts) impact.impact -= first;
  return n_added;
}

}  // namespace

std::size_t add_impacts_of_other_band(const TimedDrop& other, double begin_s, double end_s, TimedDrop& drop) {
  const bool may_infer = is_reliable(other.correlation) && !is_reliable(drop.correlation);
  return add_impacts(other, begin_s, end_s, may_infer, drop);
}

namespace {

/// Where the next track begins after a track's last impact, or the recording ends.
double end_of_track(const BandOfDrops& band, std::size_t k) {
  const std::size_t last = band.tracks[k].impacts.back().candidate;
  for (const Track& track : band.tracks)
    if (track.impacts.front().candidate > last) return band.candidates[track.impacts.front().candidate].t_s;
  return static_cast<double>(band.sound.n_samples) / band.sound.rate_hz;
}

struct TimedDrops {
  bool is_full_band = true;
  std::vector<TimedDrop> drops;

  /// Of the impacts as recorded, by the first template; absent without template.
  std::optional<double> rms_hz() const {
    const auto first = std::find_if(drops.begin(), drops.end(), [](const TimedDrop& drop) { return drop.rms_hz; });
    return first == drops.end() ? std::nullopt : first->rms_hz;
  }
};

/// Moves the times of all drops to what their templates have in common, by nothing in the mean. The contact times that
/// they are corrected for are then against one, too.
/// @param templates  phases of each; empty = none
/// @param of_drop    number of its template
void align_drops(double rate_hz, std::vector<audio::Spectrum> templates, const std::vector<std::size_t>& of_drop,
                 std::vector<TimedDrop>& drops) {
  std::vector<audio::Spectrum> learned;
  std::vector<std::size_t> place;
  for (audio::Spectrum& phases : templates) {
    place.push_back(learned.size());
    if (phases.size() > 0) learned.push_back(std::move(phases));
  }
  const std::vector<double> later = align_templates(std::move(learned), kTemplate.lead_s * rate_hz);
  double mean = 0.0, scaling = 0.0, n = 0.0;
  const auto for_each = [&](const auto& work) {
    for (std::size_t d = 0; d < drops.size(); ++d)
      if (drops[d].wave) work(drops[d], later[place[of_drop[d]]]);
  };
  for_each([&](const TimedDrop& drop, double later_samples) {
    mean += later_samples, scaling += drop.reference_scaling, n += 1.0;
  });
  for_each([&](TimedDrop& drop, double later_samples) {
    const double later_s = (later_samples - mean / n) / rate_hz;
    for (TimedImpact& impact : drop.impacts) impact.fit.t_s += later_s;
    drop.wave->t0_s -= later_s;
    drop.reference_scaling = scaling / n;
  });
}

/// Times each track by itself, on several threads.
TimedDrops time_tracks(const BandOfDrops& band, double gravity_mps2, int n_threads) {
  const std::size_t n = band.tracks.size();
  std::optional<ImpactTemplate> shared;           // of the tracks that have none of their own
  std::vector<audio::Spectrum> templates(n + 1);  // phases of each drop's own; the last one is the shared
  std::vector<std::size_t> of_drop(n, n);
  if (std::any_of(band.tracks.begin(), band.tracks.end(),
                  [](const Track& track) { return track.impacts.size() < kDrops.own_template; })) {
    WhiteSound white(band.sound);
    shared = template_of(band, band.tracks, white);
    if (shared) templates[n] = recorded_phases(*shared);
  }
  TimedDrops timed{!band.whole, std::vector<TimedDrop>(n)};
  parallel_for(n, n_threads, [&](std::size_t k) {
    const Track& track = band.tracks[k];
    WhiteSound white(band.sound);
    const std::optional<ImpactTemplate> own =
        track.impacts.size() >= kDrops.own_template ? template_of(band, {track}, white) : std::nullopt;
    const ImpactTemplate* learned = own ? &*own : shared ? &*shared : nullptr;
    if (own) templates[k] = recorded_phases(*own), of_drop[k] = k;
    timed.drops[k] = time_drop(band, track, learned, end_of_track(band, k), gravity_mps2, white);
  });
  align_drops(band.sound.rate_hz, std::move(templates), of_drop, timed.drops);
  return timed;
}

/// The contact-time law of all drops; absent without template.
std::optional<ContactLaw> contact_law_of(const TimedDrops& timed) {
  const std::optional<double> rms_hz = timed.rms_hz();
  if (!rms_hz) return std::nullopt;
  std::vector<ContactFit> evidence;
  for (const TimedDrop& drop : timed.drops)
    if (drop.contact) evidence.push_back(*drop.contact);
  return pool_contacts(evidence, assumed_contact(*rms_hz));
}

/// Median standard error of all impacts.
double median_sigma_s(std::span<const TimedDrop> drops) {
  std::vector<double> sigma_s;
  for (const TimedDrop& drop : drops)
    for (const TimedImpact& impact : drop.impacts) sigma_s.push_back(error_s(impact));
  return sigma_s.empty() ? INFINITY : upper_median(std::move(sigma_s));
}

/// Takes what another band shows of a drop in its place, moved to its time base, if a template times it there with half
/// the error; its impacts are added to that.
bool take_clearer(TimedDrop shown, double begin_s, double end_s, TimedDrop& drop) {
  if (!shown.wave || !(median_sigma_s({&shown, 1}) < kDrops.clearly_less * median_sigma_s({&drop, 1}))) return false;
  const std::vector<Shared> shared = shared_impacts(drop.impacts, shown.impacts);
  if (shared.empty()) return false;
  const double later_s = median_later_s(shared);
  for (TimedImpact& impact : shown.impacts) impact.fit.t_s += later_s;
  shown.wave->t0_s -= later_s;
  add_impacts(drop, begin_s, end_s, true, shown);
  drop = std::move(shown);
  return true;
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
    double begin_s = -INFINITY, end_s = INFINITY;  // of the drops that are not at the same time
    for (const TimedDrop& other_drop : drops) {
      if (last_s(other_drop) < first_s(drop)) begin_s = std::max(begin_s, last_s(other_drop));
      if (first_s(other_drop) > last_s(drop)) end_s = std::min(end_s, first_s(other_drop));
    }
    std::size_t n_changed = 0;
    for (const TimedDrop& shown : other.drops)
      if (first_s(shown) < last_s(drop) && last_s(shown) > first_s(drop)) {
        n_changed += take_clearer(shown, begin_s, end_s, drop) ? 1 : 0;
        n_changed += add_impacts_of_other_band(shown, begin_s, end_s, drop);
      }
    if (n_changed == 0) continue;
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
    const bool whole_is_better = n_impacts(best) >= n_impacts(*second) &&
                                 median_sigma_s(best.drops) < kDrops.clearly_less * median_sigma_s(second->drops);
    if (!whole_is_better) std::swap(best, *second);
  }
  if (second) add_drops_of_other_band(band, gravity_mps2, *second, best);
  for (const BandOfDrops& other : other_bands) {
    BandOfDrops shown = with_rms_hz(other, rms_hz);
    shown.tracks = tracks_at_those_of(band, other);
    if (!shown.tracks.empty())
      add_drops_of_other_band(band, gravity_mps2, time_tracks(shown, gravity_mps2, n_threads), best);
  }
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
      Onset onset = to_onset(drop.impacts[k], band.tracks[d].log_odds, contact, drop.peak, drop.noise_variance);
      onset.recording = name;
      onset.drop = static_cast<std::int64_t>(d);
      recording.onsets.push_back(std::move(onset));
    }
  }
  return recording;
}

}  // namespace bouncelab::detection
