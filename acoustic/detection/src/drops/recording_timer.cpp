// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/recording_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
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

/// Memory for samples of one track after another: fresh memory would cost more than what is read into it.
class SampleMemory {
 public:
  /// n samples that hold anything.
  std::span<float> of_size(std::size_t n) {
    if (n > n_held_) {
      held_.reset();
      held_ = std::unique_ptr<float[]>(new float[n]);
      n_held_ = n;
    }
    return {held_.get(), n};
  }

 private:
  std::unique_ptr<float[]> held_;
  std::size_t n_held_ = 0;
};

struct TrackMemory {
  SampleMemory recorded, white;
};

/// The sound around a track, read once into memory where it is no longer than a few minutes.
/// @param memory  of the result, which ends with its next use
audio::AudioSource held_around(const audio::AudioSource& sound, double begin_s, double end_s, SampleMemory& memory) {
  constexpr double kAround_s = 0.2;
  constexpr std::int64_t kMost = 1 << 24;  // samples, 64 MB
  const std::int64_t first =
      std::clamp<std::int64_t>(std::llround((begin_s - kAround_s) * sound.rate_hz), 0, sound.n_samples);
  const std::int64_t last =
      std::clamp<std::int64_t>(std::llround((end_s + kAround_s) * sound.rate_hz), first, sound.n_samples);
  const auto n = static_cast<std::size_t>(last - first);
  if (last - first > kMost || last == first) return sound;
  const std::span<float> samples = memory.of_size(n);
  sound.read(first, samples);
  return {sound.rate_hz, sound.n_samples, [sound, samples, first, last](std::int64_t from, std::span<float> out) {
            const std::int64_t to = from + static_cast<std::int64_t>(out.size());
            if (from >= first && to <= last)
              std::copy_n(samples.begin() + (from - first), out.size(), out.begin());
            else
              sound.read(from, out);
          }};
}

/// Samples of a track that are kept whitened: the template, the times and the levels need the same ones.
std::size_t n_whitened(double begin_s, double end_s, double rate_hz) {
  constexpr double kFewest = 1 << 17, kMost = 1 << 19;  // 2 MB
  return static_cast<std::size_t>(std::clamp((end_s - begin_s) * rate_hz, kFewest, kMost));
}

/// Where the next track begins, or the recording ends.
double end_of_track(const BandOfDrops& band, std::size_t k) {
  return k + 1 < band.tracks.size() ? band.candidates[band.tracks[k + 1].impacts.front().candidate].t_s
                                    : static_cast<double>(band.sound.n_samples) / band.sound.rate_hz;
}

LearnedWave to_learned_wave(const ImpactTemplate& learned, double rate_hz) {
  return {-learned.contact_index / rate_hz, 1.0 / rate_hz, learned.waveform, learned.spread, learned.n_impacts};
}

struct TimedDrops {
  bool is_full_band = true;
  double noise_variance = 0.0;  // in it
  std::vector<TimedDrop> drops;
  std::optional<ImpactTemplate> reference;  // the first
  std::optional<LearnedWave> wave;
  double rms_hz = 0.0;  // of the impacts as recorded, where there is a reference
};

/// Times each track by itself, on several threads; the first template is the reference of all.
class DropsTimer {
 public:
  DropsTimer(const BandOfDrops& band, double gravity_mps2, int n_threads)
      : band_(band),
        gravity_mps2_(gravity_mps2),
        n_threads_(n_threads),
        timed_{band.is_full_band(), band.noise.quiet_variance, {}, {}, {}} {
    const bool is_shared = std::any_of(band.tracks.begin(), band.tracks.end(),
                                       [](const Track& track) { return track.impacts.size() < kDrops.own_template; });
    if (!is_shared) return;
    WhiteSound white(band.sound);
    shared_ = template_of(band, band.tracks, white);
  }

  TimedDrops run() {
    const std::size_t n = band_.tracks.size();
    timed_.drops.resize(n);
    std::size_t first = 0;
    while (first < n && !timed_.reference) time(first++);
    parallel_for(n - first, n_threads_, [&](std::size_t k) { time(first + k); });
    if (timed_.reference) timed_.rms_hz = rms_hz_of(band_, *timed_.reference);
    return std::move(timed_);
  }

 private:
  void time(std::size_t k) {
    const Track& track = band_.tracks[k];
    const double begin_s = band_.candidates[track.impacts.front().candidate].t_s;
    const double last_s = band_.candidates[track.impacts.back().candidate].t_s;
    TrackMemory memory = take_memory();
    const audio::AudioSource sound = held_around(band_.sound, begin_s, last_s, memory.recorded);
    WhiteSound white(sound, memory.white.of_size(n_whitened(begin_s, last_s, sound.rate_hz)));
    const std::optional<ImpactTemplate> own =
        track.impacts.size() >= kDrops.own_template ? template_of(band_, {track}, white) : std::nullopt;
    const ImpactTemplate* learned = own ? &*own : shared_ ? &*shared_ : nullptr;
    TimedDrop& drop = timed_.drops[k];
    drop = time_drop(band_, track, learned, end_of_track(band_, k), gravity_mps2_, white);
    if (learned != nullptr && !timed_.reference)  // nothing else is being timed yet
      timed_.reference = *learned;
    const std::lock_guard lock(results_);
    memories_.push_back(std::move(memory));
    if (learned != nullptr) show_if_longest(k, *learned);
  }

  TrackMemory take_memory() {
    const std::lock_guard lock(results_);
    if (memories_.empty()) return {};
    TrackMemory memory = std::move(memories_.back());
    memories_.pop_back();
    return memory;
  }

  /// Of equally long ones the first.
  void show_if_longest(std::size_t k, const ImpactTemplate& learned) {
    const std::size_t n = band_.tracks[k].impacts.size();
    if (timed_.wave && (n < n_longest_ || (n == n_longest_ && k > longest_))) return;
    n_longest_ = n;
    longest_ = k;
    timed_.wave = to_learned_wave(learned, band_.sound.rate_hz);
  }

  const BandOfDrops& band_;
  double gravity_mps2_;
  int n_threads_;
  std::optional<ImpactTemplate> shared_;  // of the tracks that have none of their own
  TimedDrops timed_;
  std::mutex results_;  // of what follows
  std::vector<TrackMemory> memories_;
  std::size_t longest_ = 0, n_longest_ = 0;
};

/// The contact-time law of all drops; where they do not determine it, the assumed one; absent without template.
std::optional<ContactLaw> contact_law_of(const TimedDrops& timed) {
  if (!timed.reference) return std::nullopt;
  std::vector<ContactEvidence> evidence;
  for (const TimedDrop& drop : timed.drops)
    if (drop.contact) evidence.push_back(*drop.contact);
  const ContactLaw assumed = assumed_contact(timed.rms_hz);
  return evidence.empty() ? assumed : pool_contacts(evidence, assumed);
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

/// The same tracks timed in several bands, the best first.
struct TimedBands {
  std::vector<TimedDrops> bands;
  std::optional<double> rms_hz;  // of the impacts in the whole sound
};

std::optional<double> rms_hz_of(const TimedDrops& timed) {
  return timed.reference ? std::optional(timed.rms_hz) : std::nullopt;
}

BandOfDrops with_rms_hz(BandOfDrops band, std::optional<double> rms_hz) {
  if (!band.is_full_band()) band.recorded_rms_hz = rms_hz;
  return band;
}

/// A band in which impacts stand out from clutter need not be the one that times them best: low frequencies hold little
/// of the information. Times them in the whole sound too, and takes that where no impact is lost and the errors are
/// half as large: the lesser of two estimated errors is too small by chance.
TimedBands time_drops_in_best_band(const BandOfDrops& band, double gravity_mps2, int n_threads) {
  TimedBands timed;
  if (band.is_full_band()) {
    timed.bands.push_back(DropsTimer(band, gravity_mps2, n_threads).run());
    timed.rms_hz = rms_hz_of(timed.bands.front());
    return timed;
  }
  BandOfDrops whole = band;
  whole.sound = *band.whole;
  whole.whole.reset();
  whole.noise = learn_ar_models(whole.sound, static_cast<int>(band.noise.filter.size()) - 2).noise;
  TimedDrops in_whole = DropsTimer(whole, gravity_mps2, n_threads).run();
  timed.rms_hz = rms_hz_of(in_whole);
  const BandOfDrops with_rms = with_rms_hz(band, timed.rms_hz);
  TimedDrops in_band = DropsTimer(with_rms, gravity_mps2, n_threads).run();
  const bool is_better = n_impacts(in_whole) >= n_impacts(in_band) &&
                         median_sigma_s(in_whole) < kDrops.clearly_less * median_sigma_s(in_band);
  timed.bands.push_back(std::move(is_better ? in_whole : in_band));
  timed.bands.push_back(std::move(is_better ? in_band : in_whole));
  return timed;
}

double first_s(const TimedDrop& drop) { return drop.impacts.front().fit.t_s; }
double last_s(const TimedDrop& drop) { return drop.impacts.back().fit.t_s; }

/// Adds to each drop what another band shows of it.
void add_drops_of_other_band(const BandOfDrops& band, double gravity_mps2, const TimedDrops& other, TimedDrops& timed) {
  for (std::size_t k = 0; k < timed.drops.size(); ++k) {
    TimedDrop& drop = timed.drops[k];
    if (drop.impacts.empty()) continue;
    const bool is_first = k == 0 || timed.drops[k - 1].impacts.empty();
    const bool is_last = k + 1 == timed.drops.size() || timed.drops[k + 1].impacts.empty();
    const double begin_s = is_first ? -INFINITY : last_s(timed.drops[k - 1]);
    const double end_s = is_last ? INFINITY : first_s(timed.drops[k + 1]);
    std::size_t n_added = 0;
    for (const TimedDrop& shown : other.drops)
      if (!shown.impacts.empty() && first_s(shown) < last_s(drop) && last_s(shown) > first_s(drop)) {
        n_added += add_impacts_of_other_band(shown, begin_s, end_s, drop);
      }
    if (n_added == 0) continue;
    set_speeds(gravity_mps2, drop.impacts);
    mark_clipped(band.whole ? *band.whole : band.sound, drop.impacts);
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
TimedDrops time_drops(const BandOfDrops& band, const std::vector<BandOfDrops>& other_bands, double gravity_mps2,
                      int n_threads) {
  TimedBands of_tracks = time_drops_in_best_band(band, gravity_mps2, n_threads);
  TimedDrops best = std::move(of_tracks.bands.front());
  for (const BandOfDrops& other : other_bands) {
    std::vector<Track> tracks = tracks_at_those_of(band, other);
    if (tracks.empty()) continue;
    BandOfDrops shown = with_rms_hz(other, of_tracks.rms_hz);
    shown.tracks = std::move(tracks);
    add_drops_of_other_band(band, gravity_mps2, DropsTimer(shown, gravity_mps2, n_threads).run(), best);
  }
  if (of_tracks.bands.size() > 1) add_drops_of_other_band(band, gravity_mps2, of_tracks.bands.back(), best);
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
  TimedDrops timed = time_drops(band, other_bands, gravity_mps2, n_threads);
  recording.wave = std::move(timed.wave);
  recording.is_full_band = timed.is_full_band;
  const std::optional<ContactLaw> law = contact_law_of(timed);
  if (law && law->is_significant) recording.contact_time_at_1_mps_s = law->tau_1_s;
  if (law) recording.contact_time_sigma_s = law->sigma_s;
  for (std::size_t d = 0; d < timed.drops.size(); ++d) {
    const TimedDrop& drop = timed.drops[d];
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
