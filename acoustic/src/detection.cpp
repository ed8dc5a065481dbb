// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/acoustic/detection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "autoregression.hpp"
#include "bouncelab/acoustic/audio_reader.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/units.hpp"
#include "candidates.hpp"
#include "contact_law.hpp"
#include "impact_timing.hpp"
#include "low_band.hpp"
#include "train_timing.hpp"
#include "trains.hpp"

namespace bouncelab {
namespace {

// enough poles for the loudest twenty-odd modes of a plate; more buys nothing on noise
constexpr int kOrder = 48;
constexpr double kLowRate_hz = 4e3;   // sampling rate of the low band: soft balls end at 1.5 kHz
constexpr double kConvincing = 40.0;  // log odds of trains, about a dozen impacts

/// What one channel has to say.
struct Hearing {
  Sound sound;  // in the band that was heard best
  int channel = 0;
  SoundModels models;
  std::vector<Candidate> candidates;
  std::vector<Train> trains;

  double log_odds() const {
    double sum = 0.0;
    for (const Train& train : trains) sum += train.log_odds;
    return sum;
  }
};

Hearing hear(const Sound& sound, int channel, const ProgressCallback& progress) {
  Hearing h;
  h.sound = sound;
  h.channel = channel;
  h.models = learn_sound_models(sound, kOrder);
  h.candidates = find_candidates(sound, h.models.all, progress);
  h.trains = find_trains(h.candidates, 2.0 / sound.rate_hz);
  return h;
}

/// Hears the channel in its whole band and, where that leaves doubt, in the low band of soft balls.
Hearing hear_in_bands(const Sound& sound, int channel, const ProgressCallback& progress) {
  Hearing whole = hear(sound, channel, progress);
  const int factor = static_cast<int>(sound.rate_hz / kLowRate_hz);
  if (factor < 2 || whole.log_odds() > kConvincing) return whole;
  Hearing low = hear(low_band(sound, factor), channel, progress);
  return low.log_odds() > whole.log_odds() ? std::move(low) : std::move(whole);
}

/// Standard deviation of the innovations in the quiet tenth: noise without hum and drift.
double quiet_rms(const Hearing& h) { return std::sqrt(h.models.noise.quiet_variance); }

/// Times as the rise of the sound has them, where no wave could be learned.
std::vector<TrainOnset> rough_onsets(const Hearing& h, const Train& train) {
  std::vector<TrainOnset> onsets;
  for (const TrainImpact& impact : train.impacts) {
    const Candidate& c = h.candidates[impact.candidate];
    TrainOnset onset;
    onset.impact = impact.impact;
    onset.timed.t_s = c.t_s;
    onset.timed.sigma_s = 0.25 * c.reach_s;
    onsets.push_back(onset);
  }
  return onsets;
}

Onset to_onset(const TrainOnset& from, std::int64_t drop, const std::string& name) {
  Onset onset;
  onset.recording = name;
  onset.drop = drop;
  onset.impact = from.impact;
  onset.t_s = from.timed.t_s;
  onset.sigma_t_s = from.timed.sigma_s;
  if (from.inferred) add_flag(onset.flags, "inferred");
  if (from.overlap) add_flag(onset.flags, "overlap");
  return onset;
}

std::optional<ImpactWave> learn_wave(const Hearing& h) {
  std::vector<RoughImpact> rough;
  for (const Train& train : h.trains)
    for (const TrainImpact& impact : train.impacts) {
      const Candidate& c = h.candidates[impact.candidate];
      rough.push_back({c.t_s, c.amplitude, c.reach_s});
    }
  return learn_impact_wave(h.sound, h.models.noise, rough);
}

/// Did the converter reach its limit: three successive samples of the same value, the largest around?
bool is_clipped(const Sound& sound, double t_s) {
  constexpr double kAround_s = 5e-3;
  std::vector<float> x(static_cast<std::size_t>(kAround_s * sound.rate_hz) + 3);
  read_padded(sound, std::llround(t_s * sound.rate_hz) - 1, x);
  float largest = 0.0F;
  for (const float value : x) largest = std::max(largest, std::abs(value));
  for (std::size_t k = 2; k < x.size(); ++k)
    if (std::abs(x[k]) == largest && largest > 0.0F && x[k - 1] == x[k] && x[k - 2] == x[k]) return true;
  return false;
}

Onsets time_all(const Hearing& h, const std::optional<ImpactWave>& wave, const Sound& sound, const std::string& name) {
  Onsets onsets;
  for (std::size_t drop = 0; drop < h.trains.size(); ++drop) {
    const double end_s = drop + 1 < h.trains.size() ? h.candidates[h.trains[drop + 1].impacts.front().candidate].t_s
                                                    : static_cast<double>(h.sound.n_samples) / h.sound.rate_hz;
    for (const TrainOnset& from :
         wave ? time_train(h.sound, *wave, h.trains[drop], h.candidates, end_s) : rough_onsets(h, h.trains[drop])) {
      Onset onset = to_onset(from, static_cast<std::int64_t>(drop), name);
      if (wave) {
        onset.amplitude = from.timed.amplitude * wave->peak;
        onset.snr_db = 20.0 * std::log10(*onset.amplitude / quiet_rms(h));
      }
      if (is_clipped(sound, onset.t_s)) add_flag(onset.flags, "clipped");
      onsets.push_back(std::move(onset));
    }
  }
  return onsets;
}

/// Speeds from the flights before (of a drop's first impact: from the flight after it) [m/s]; 0 = not known.
std::vector<double> speeds_of(const Onsets& onsets) {
  std::vector<double> v_mps(onsets.size(), 0.0);
  const auto flight_s = [&](std::size_t k) {  // between onset k - 1 and k; 0 where one between them was not heard
    const bool neighbours = onsets[k].drop == onsets[k - 1].drop && onsets[k].impact == onsets[k - 1].impact + 1;
    return neighbours ? onsets[k].t_s - onsets[k - 1].t_s : 0.0;
  };
  for (std::size_t k = 1; k < onsets.size(); ++k) v_mps[k] = 0.5 * kDefaultGravity_mps2 * flight_s(k);
  for (std::size_t k = 0; k + 1 < onsets.size(); ++k)
    if (v_mps[k] == 0.0) v_mps[k] = 0.5 * kDefaultGravity_mps2 * flight_s(k + 1);
  return v_mps;
}

/// Moves the times to the start of contact by the contact-time law that the recording shows.
std::optional<ContactLaw> correct_for_contact(const Hearing& h, const ImpactWave& wave, Onsets& onsets) {
  const std::vector<double> v_mps = speeds_of(onsets);
  std::vector<SpeedAndTime> clear;
  for (std::size_t k = 0; k < onsets.size(); ++k)
    if (v_mps[k] > 0.0 && onsets[k].flags.empty()) clear.push_back({onsets[k].t_s, *onsets[k].amplitude, v_mps[k]});
  const std::optional<ContactLaw> law = learn_contact_law(h.sound, wave, clear);
  if (!law) return law;
  for (std::size_t k = 0; k < onsets.size(); ++k) {
    if (!(v_mps[k] > 0.0)) continue;
    const double delay_s = law->delay_s(v_mps[k]);
    onsets[k].t_s -= delay_s;
    onsets[k].sigma_t_s = std::hypot(*onsets[k].sigma_t_s, delay_s * law->sigma_s / law->tau_1_s);
  }
  return law;
}

LearnedWave to_learned_wave(const ImpactWave& wave, double rate_hz) {
  return {-wave.contact_index / rate_hz, 1.0 / rate_hz, wave.heard, wave.spread, wave.n_impacts};
}

NoiseSpectrum noise_spectrum(const Hearing& h) {
  constexpr int kPoints = 256;
  NoiseSpectrum spectrum;
  for (int k = 1; k <= kPoints; ++k) {  // zero is left out: the model takes the difference first
    spectrum.frequency_hz.push_back(0.5 * h.sound.rate_hz * k / kPoints);
    spectrum.psd.push_back(quiet_psd(h.models.noise, h.sound.rate_hz, spectrum.frequency_hz.back()));
  }
  return spectrum;
}

void summarize_trains(const Hearing& h, RecordingSummary& summary) {
  summary.n_candidates = static_cast<std::int64_t>(h.candidates.size());
  summary.n_drops = static_cast<std::int64_t>(h.trains.size());
  std::vector<double> eps;
  for (const Train& train : h.trains)
    for (std::size_t k = 2; k < train.impacts.size(); ++k) {
      if (train.impacts[k].impact - train.impacts[k - 2].impact != 2) continue;
      const double t0 = h.candidates[train.impacts[k - 2].candidate].t_s;
      const double t1 = h.candidates[train.impacts[k - 1].candidate].t_s;
      const double t2 = h.candidates[train.impacts[k].candidate].t_s;
      eps.push_back((t2 - t1) / (t1 - t0));
    }
  if (eps.empty()) return;
  const auto middle = eps.begin() + static_cast<std::ptrdiff_t>(eps.size() / 2);
  std::nth_element(eps.begin(), middle, eps.end());
  summary.restitution_median = *middle;
}

void conclude(Detection& d) {
  if (!d.onsets.empty()) {
    d.status = DetectionStatus::ok;
    d.message = std::to_string(d.onsets.size()) + " impacts in " + std::to_string(d.summary.n_drops) +
                (d.summary.n_drops == 1 ? " drop" : " drops");
  } else if (d.summary.n_candidates > 0) {
    d.status = DetectionStatus::too_few_impacts;
    d.message =
        std::to_string(d.summary.n_candidates) +
        " sounds that rise like impacts, but no five of them in intervals that shrink like those of a bouncing ball";
  } else {
    d.status = DetectionStatus::silent;
    d.message = "nothing rises above the noise";
  }
}

template <class SoundOfChannel>
Detection detect_in(const SoundOfChannel& sound_of, int n_channels, const std::string& name,
                    const DetectionConfig& config, const ProgressCallback& progress) {
  if (config.channel && (*config.channel < 0 || *config.channel >= n_channels))
    throw InvalidArgument("channel " + std::to_string(*config.channel) + ": " + name + " has channels 0 to " +
                          std::to_string(n_channels - 1));
  Detection d;
  Hearing best;
  const int first = config.channel.value_or(0);
  const int last = config.channel ? first + 1 : n_channels;
  for (int channel = first; channel < last; ++channel) {
    Hearing h = hear_in_bands(sound_of(channel), channel, progress);
    if (channel == first || h.log_odds() > best.log_odds()) best = std::move(h);
  }
  const Sound sound = sound_of(best.channel);
  d.summary.rate_hz = sound.rate_hz;
  d.summary.n_channels = n_channels;
  d.summary.channel = best.channel;
  d.summary.channel_reason = config.channel    ? "asked for"
                             : n_channels == 1 ? "the only one"
                                               : "its impacts form the clearest trains";
  d.summary.duration_s = static_cast<double>(sound.n_samples) / sound.rate_hz;
  d.summary.noise_rms = quiet_rms(best);
  summarize_trains(best, d.summary);
  const std::optional<ImpactWave> wave = learn_wave(best);
  d.onsets = time_all(best, wave, sound, name);
  if (wave)
    if (const auto law = correct_for_contact(best, *wave, d.onsets)) d.summary.contact_time_at_1_mps_s = law->tau_1_s;
  if (wave) d.wave = to_learned_wave(*wave, best.sound.rate_hz);
  if (best.models.noise.quiet_variance > 0.0) d.noise = noise_spectrum(best);
  conclude(d);
  return d;
}

}  // namespace

Detection detect(const std::filesystem::path& recording, const DetectionConfig& config,
                 const ProgressCallback& progress) {
  AudioReader reader(recording);
  return detect_in([&](int channel) { return reader.sound(channel); }, reader.format().n_channels, recording.string(),
                   config, progress);
}

Detection detect(std::span<const float> samples, double rate_hz, const std::string& name, const DetectionConfig& config,
                 const ProgressCallback& progress) {
  const Sound sound = sound_in_memory(samples, rate_hz);
  return detect_in([&](int) { return sound; }, 1, name, config, progress);
}

}  // namespace bouncelab
