// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/recording_timer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bouncelab/core/units.hpp"
#include "contact/contact_time.hpp"
#include "timing/impact_template.hpp"
#include "timing/impact_timer.hpp"
#include "timing/overlap_separation.hpp"
#include "timing/track_timer.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kOwnWave = 12;  // impacts from which a train has a wave of its own: its noise is then 11 dB down

/// One train, timed.
struct TimedDrop {
  Onsets onsets;
  std::vector<double> v_mps;  // from the flight before each onset (of the first: after it, over eps); 0 = not known
  std::optional<ContactEvidence> contact;
  double reference_scaling = 0.0;  // v^(-1/5) of its strongest impacts
};

/// Where the converter reached its limit within 5 ms of t_s: three successive samples of the same value, the largest
/// around. Infinity where it did not.
float clip_level(const audio::AudioSource& sound, double t_s) {
  constexpr double kAround_s = 5e-3;
  std::vector<float> x(static_cast<std::size_t>(kAround_s * sound.rate_hz) + 3);
  audio::read_padded(sound, std::llround(t_s * sound.rate_hz) - 1, x);
  int n_flat = 0;  // most sounds have none, which is seen by vectors
  for (std::size_t k = 2; k < x.size(); ++k) n_flat += (x[k] == x[k - 1]) & (x[k] == x[k - 2]) & (x[k] != 0.0F) ? 1 : 0;
  if (n_flat == 0) return INFINITY;
  float largest = 0.0F;
  for (const float value : x) largest = std::max(largest, std::abs(value));
  for (std::size_t k = 2; k < x.size(); ++k)
    if (std::abs(x[k]) == largest && largest > 0.0F && x[k - 1] == x[k] && x[k - 2] == x[k]) return largest;
  return INFINITY;
}

/// Least level at which impacts of the train are clipped. In the low band nothing is left of where the converter
/// stopped.
float clip_level(const TimingInput& heard, const std::vector<RoughImpact>& impacts) {
  float level = INFINITY;
  if (heard.band.rate_hz != heard.whole.rate_hz) return level;
  for (const RoughImpact& impact : impacts) level = std::min(level, clip_level(heard.whole, impact.t_s));
  return 0.999F * level;
}

void add_rough(const TimingInput& heard, const Train& train, std::vector<RoughImpact>& rough) {
  for (const TrainImpact& impact : train.impacts) {
    const Candidate& c = heard.candidates[impact.candidate];
    rough.push_back({c.t_s, c.amplitude, c.reach_s, !std::isinf(clip_level(heard.whole, c.t_s))});
  }
}

std::optional<ImpactTemplate> learn(const audio::AudioSource& band, const TimingInput& heard,
                                    const std::vector<RoughImpact>& rough) {
  std::optional<ImpactTemplate> wave = estimate_template(band, heard.noise, rough);
  // a wave learned from clipped impacts is clipped alike: then what is beyond the limit fits, and left out it would not
  const auto n_whole = std::count_if(rough.begin(), rough.end(), [](const RoughImpact& r) { return !r.clipped; });
  if (wave && n_whole >= kFewestWhole) wave->clip_level = clip_level(heard, rough);
  return wave;
}

std::optional<ImpactTemplate> wave_of_train(const audio::AudioSource& band, const TimingInput& heard,
                                            const Train& train) {
  std::vector<RoughImpact> rough;
  add_rough(heard, train, rough);
  return learn(band, heard, rough);
}

/// The sound around a train, read once into memory where it is no longer than a few minutes.
audio::AudioSource held(const audio::AudioSource& sound, double begin_s, double end_s, std::vector<float>& room) {
  constexpr double kAround_s = 0.2;
  constexpr std::int64_t kMost = 1 << 24;  // samples, 64 MB
  const std::int64_t first =
      std::clamp<std::int64_t>(std::llround((begin_s - kAround_s) * sound.rate_hz), 0, sound.n_samples);
  const std::int64_t last =
      std::clamp<std::int64_t>(std::llround((end_s + kAround_s) * sound.rate_hz), first, sound.n_samples);
  const auto n = static_cast<std::size_t>(last - first);
  if (last - first > kMost || last == first || !audio::resident_span(sound, first, n).empty()) return sound;
  room.resize(n);
  sound.read(first, room);
  return {sound.rate_hz, sound.n_samples,
          [sound, &room, first, last](std::int64_t from, std::span<float> out) {
            const std::int64_t to = from + static_cast<std::int64_t>(out.size());
            if (from >= first && to <= last)
              std::copy_n(room.begin() + (from - first), out.size(), out.begin());
            else
              sound.read(from, out);
          },
          room, first};
}

std::optional<ImpactTemplate> wave_of_recording(const TimingInput& heard) {
  std::vector<RoughImpact> rough;
  for (const Train& train : heard.trains) add_rough(heard, train, rough);
  return learn(heard.band, heard, rough);
}

/// Times as the rise of the sound has them, where no wave could be learned.
std::vector<TimedTrackImpact> rough_onsets(const TimingInput& heard, const Train& train) {
  std::vector<TimedTrackImpact> onsets;
  for (const TrainImpact& impact : train.impacts) {
    const Candidate& c = heard.candidates[impact.candidate];
    TimedTrackImpact onset;
    onset.impact = impact.impact;
    onset.timed.t_s = c.t_s;
    onset.timed.sigma_s = 0.25 * c.reach_s;
    onsets.push_back(onset);
  }
  return onsets;
}

Onset to_onset(const TimedTrackImpact& from, const TimingInput& heard, const ImpactTemplate* wave) {
  Onset onset;
  onset.impact = from.impact;
  onset.t_s = from.timed.t_s;
  onset.sigma_t_s = std::hypot(from.timed.sigma_s, from.doubt_s);
  if (wave != nullptr) {
    onset.amplitude = from.timed.amplitude * wave->peak;
    onset.snr_db = 20.0 * std::log10(*onset.amplitude / std::sqrt(heard.noise.quiet_variance));
  }
  if (!std::isinf(clip_level(heard.whole, onset.t_s))) onset.flags.add(Flag::clipped);
  if (from.overlap) onset.flags.add(Flag::overlap);
  if (from.inferred) onset.flags.add(Flag::inferred);
  if (from.doubtful) onset.flags.add(Flag::doubtful);
  return onset;
}

bool is_clear(const TimedTrackImpact& onset, const TimingInput& heard) {
  return !onset.overlap && !onset.inferred && !onset.doubtful && std::isinf(clip_level(heard.whole, onset.timed.t_s));
}

std::vector<double> speeds_of(const std::vector<TimedTrackImpact>& onsets) {
  std::vector<double> v_mps(onsets.size(), 0.0);
  const auto flight_s = [&](std::size_t k) {  // between onset k - 1 and k; 0 where one between them was not heard
    return onsets[k].impact == onsets[k - 1].impact + 1 ? onsets[k].timed.t_s - onsets[k - 1].timed.t_s : 0.0;
  };
  for (std::size_t k = 1; k < onsets.size(); ++k) v_mps[k] = 0.5 * kDefaultGravity_mps2 * flight_s(k);
  for (std::size_t k = 0; k + 1 < onsets.size(); ++k)
    if (v_mps[k] == 0.0 && flight_s(k + 1) > 0.0) {
      const double next_s = k + 2 < onsets.size() ? flight_s(k + 2) : 0.0;
      // which takes the speed after the impact to that before
      const double eps = next_s > 0.0 ? std::clamp(next_s / flight_s(k + 1), 0.3, 1.0) : 1.0;
      v_mps[k] = 0.5 * kDefaultGravity_mps2 * flight_s(k + 1) / eps;
    }
  return v_mps;
}

/// v^(-1/5) of the impacts that the wave is mostly learned from.
double reference_scaling(const std::vector<SpeedAndTime>& impacts) {
  double sum = 0.0;
  double weight = 1e-300;
  for (const SpeedAndTime& impact : impacts) {
    sum += impact.amplitude * impact.amplitude * std::pow(impact.v_mps, -0.2);
    weight += impact.amplitude * impact.amplitude;
  }
  return sum / weight;
}

TimedDrop time_drop(const audio::AudioSource& band, const TimingInput& heard, const Train& train,
                    const ImpactTemplate* wave, double end_s) {
  TimedDrop drop;
  std::vector<TimedTrackImpact> onsets =
      wave != nullptr ? time_track(band, *wave, train, heard.candidates, end_s) : rough_onsets(heard, train);
  drop.v_mps = speeds_of(onsets);
  if (wave != nullptr) {
    std::vector<SpeedAndTime> all;
    std::vector<SpeedAndTime> clear;
    for (std::size_t k = 0; k < onsets.size(); ++k) {
      if (!(drop.v_mps[k] > 0.0)) continue;
      all.push_back({onsets[k].timed.t_s, onsets[k].timed.amplitude, drop.v_mps[k]});
      if (is_clear(onsets[k], heard)) clear.push_back(all.back());
    }
    drop.contact = fit_contact(read_levels(band, *wave, clear));
    drop.reference_scaling = reference_scaling(clear.empty() ? all : clear);
    std::vector<double> u;
    for (const double v_mps : drop.v_mps) u.push_back(v_mps > 0.0 ? std::pow(v_mps, -0.2) : 0.0);
    const std::optional<ContactLaw> law = drop.contact ? pool_contacts({*drop.contact}) : std::nullopt;
    separate_overlaps(band, *wave, law, u, drop.reference_scaling, onsets);
  }
  for (const TimedTrackImpact& onset : onsets) drop.onsets.push_back(to_onset(onset, heard, wave));
  return drop;
}

/// The wave that the subbands of all drops are set to.
struct Reference {
  ImpactTemplate wave;
  double u = 0.0;
};

/// Each drop's wave was learned by itself and has its own idea of where contact begins, by a sample or two: moves a
/// drop whose impacts sound like it to what the reference wave says of its strongest impacts.
void set_to(const Reference& reference, const ImpactTemplate& own, const audio::AudioSource& band, TimedDrop& drop) {
  constexpr std::size_t kHeard = 5;
  constexpr double kReach_s = 0.2e-3;
  constexpr double kAlike = 0.9;  // of the correlation with its own wave: the same modes were struck
  std::vector<std::size_t> clear;
  for (std::size_t k = 0; k + 1 < drop.onsets.size(); ++k)
    if (drop.onsets[k].flags.empty()) clear.push_back(k);
  const auto stronger = [&](std::size_t a, std::size_t b) {
    return *drop.onsets[a].amplitude > *drop.onsets[b].amplitude;
  };
  std::sort(clear.begin(), clear.end(), stronger);
  if (clear.size() < kHeard) return;
  ImpactTimer timer(band, reference.wave);
  std::vector<double> later_s;
  for (std::size_t k = 0; k < kHeard; ++k) {
    const Onset& onset = drop.onsets[clear[k]];
    const TimedImpact timed = timer.time(onset.t_s, kReach_s, drop.onsets[clear[k] + 1].t_s);
    if (timed.correlation > kAlike * own.correlation) later_s.push_back(timed.t_s - onset.t_s);
  }
  if (later_s.size() < kHeard) return;
  std::nth_element(later_s.begin(), later_s.begin() + kHeard / 2, later_s.end());
  for (Onset& onset : drop.onsets) onset.t_s += later_s[kHeard / 2];
  drop.reference_scaling = reference.u;
}

std::optional<ContactLaw> contact_law_of(const std::vector<TimedDrop>& drops) {
  std::vector<ContactEvidence> evidence;
  for (const TimedDrop& drop : drops)
    if (drop.contact) evidence.push_back(*drop.contact);
  return pool_contacts(evidence);
}

/// Moves the times to the start of contact. An error of the law moves all impacts of a drop alike but for how much
/// slower one is than the next: what that does to an interval is the part of it that sigma holds.
void correct_for_contact(const ContactLaw& law, TimedDrop& drop) {
  const auto delay = [&](std::size_t k) { return contact_delay(drop.v_mps[k], drop.reference_scaling); };
  for (std::size_t k = 0; k < drop.onsets.size(); ++k) {
    if (!(drop.v_mps[k] > 0.0)) continue;
    double against_neighbours = 0.0;
    for (const std::size_t j : {k - 1, k + 1})
      if (j < drop.onsets.size() && drop.v_mps[j] > 0.0)
        against_neighbours = std::max(against_neighbours, std::abs(delay(k) - delay(j)));
    drop.onsets[k].t_s -= delay(k) * law.tau_1_s;
    drop.onsets[k].sigma_t_s = std::hypot(*drop.onsets[k].sigma_t_s, against_neighbours * law.sigma_s);
  }
}

LearnedWave to_learned_wave(const ImpactTemplate& wave, double rate_hz) {
  return {-wave.contact_index / rate_hz, 1.0 / rate_hz, wave.waveform, wave.spread, wave.n_impacts};
}

}  // namespace

TimedRecording time_recording(const TimingInput& heard, const std::string& name) {
  TimedRecording timed;
  std::vector<TimedDrop> drops;
  std::optional<ImpactTemplate> shared;
  const bool share = std::any_of(heard.trains.begin(), heard.trains.end(),
                                 [](const Train& train) { return train.impacts.size() < kOwnWave; });
  if (share) shared = wave_of_recording(heard);
  std::optional<Reference> reference;
  std::size_t longest = 0;
  std::vector<float> room;
  for (std::size_t k = 0; k < heard.trains.size(); ++k) {
    const Train& train = heard.trains[k];
    const double end_s = k + 1 < heard.trains.size()
                             ? heard.candidates[heard.trains[k + 1].impacts.front().candidate].t_s
                             : static_cast<double>(heard.band.n_samples) / heard.band.rate_hz;
    const double begin_s = heard.candidates[train.impacts.front().candidate].t_s;
    const double last_s = heard.candidates[train.impacts.back().candidate].t_s;
    const audio::AudioSource band = held(heard.band, begin_s, last_s, room);
    const TimingInput here{band, heard.band.rate_hz == heard.whole.rate_hz ? band : heard.whole, heard.noise,
                           heard.candidates, heard.trains};
    const std::optional<ImpactTemplate> own =
        train.impacts.size() >= kOwnWave ? wave_of_train(band, here, train) : std::nullopt;
    const ImpactTemplate* wave = own ? &*own : shared ? &*shared : nullptr;
    drops.push_back(time_drop(band, here, train, wave, end_s));
    if (wave != nullptr && reference) set_to(*reference, *wave, band, drops.back());
    if (wave != nullptr && !reference) reference = Reference{*wave, drops.back().reference_scaling};
    if (wave != nullptr && train.impacts.size() > longest) {
      longest = train.impacts.size();
      timed.wave = to_learned_wave(*wave, heard.band.rate_hz);
    }
  }
  std::optional<ContactLaw> law = contact_law_of(drops);
  if (!law && reference) law = assumed_contact(reference->wave.wave.rms_frequency() * heard.band.rate_hz);
  if (law && law->is_significant) timed.contact_time_at_1_mps_s = law->tau_1_s;
  if (law) timed.contact_time_sigma_s = law->sigma_s;
  for (std::size_t k = 0; k < drops.size(); ++k) {
    if (law) correct_for_contact(*law, drops[k]);
    for (Onset& onset : drops[k].onsets) {
      onset.recording = name;
      onset.drop = static_cast<std::int64_t>(k);
      timed.onsets.push_back(std::move(onset));
    }
  }
  return timed;
}

}  // namespace bouncelab::detection
