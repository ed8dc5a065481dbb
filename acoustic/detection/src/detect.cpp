// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/detect.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/audio/dsp/decimate.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "candidates/band_energies.hpp"
#include "candidates/candidates.hpp"
#include "timing/recording_timer.hpp"
#include "tracking/bounce_model.hpp"
#include "tracking/first_arrivals.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {
namespace {

// enough poles for the loudest twenty-odd modes of a plate; more buys nothing on noise
constexpr int kArOrder = 48;
// sampling rates of the low bands: rubber ends at 1.5 kHz, a basketball's thump at 200 Hz
constexpr std::array<double, 2> kLowBandRates_hz{4e3, 1e3};
constexpr double kBandSelectionMargin = 1.5;  // log odds: of three bands one is best by chance
constexpr double kLowestRate_hz = 4e3;
constexpr double kHighestRate_hz = 4e6;
constexpr double kConclusiveLogOdds = 40.0;  // log odds of trains, about a dozen impacts

/// What one channel has to say.
struct ChannelDetection {
  audio::AudioSource sound;  // in the band that was heard best
  int channel = 0;
  audio::ArModels models;
  std::vector<Candidate> candidates;
  std::vector<Train> trains;

  double log_odds() const {
    double sum = 0.0;
    for (const Train& train : trains) sum += train.log_odds;
    return sum;
  }
};

/// Whether there may be other trains than these, or none: one is not beyond doubt, or enough of what is as loud is
/// left.
bool may_miss_tracks(const std::vector<Candidate>& candidates, const std::vector<Train>& trains) {
  constexpr double kAsLoud = 0.25;
  constexpr std::size_t kFewImpacts = 4;
  constexpr double kShortTrain_s = 5.0;
  std::vector<double> own;
  for (const Train& train : trains) {
    if (train.log_odds < kConclusiveLogOdds) return true;
    for (const TrainImpact& impact : train.impacts) own.push_back(candidates[impact.candidate].amplitude);
  }
  if (own.empty()) return true;
  std::nth_element(own.begin(), own.begin() + std::ssize(own) / 2, own.end());
  const double loud = kAsLoud * own[own.size() / 2];
  std::vector<bool> is_own(candidates.size(), false);
  for (const Train& train : trains)
    for (const TrainImpact& impact : train.impacts) is_own[impact.candidate] = true;
  std::vector<double> left_s;
  double last_s = -INFINITY;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (is_own[k])
      last_s = candidates[k].t_s;
    else if (candidates[k].amplitude > loud && candidates[k].t_s - last_s > kEcho_s)
      left_s.push_back(candidates[k].t_s);
  }
  for (std::size_t k = kFewImpacts; k <= left_s.size(); ++k)
    if (left_s[k - 1] - left_s[k - kFewImpacts] < kShortTrain_s) return true;
  return false;
}

ChannelDetection detect_channel(const audio::AudioSource& sound, int channel, const ProgressCallback& progress) {
  ChannelDetection h;
  h.sound = sound;
  h.channel = channel;
  h.models = audio::learn_ar_models(sound, kArOrder);
  h.candidates = find_candidates(sound, h.models.signal, progress);
  h.trains = find_trains(h.candidates, 2.0 / sound.rate_hz);
  if (may_miss_tracks(h.candidates, h.trains))
    h.trains = find_trains(h.candidates, 2.0 / sound.rate_hz, measure_band_energies(sound, h.candidates));
  begin_at_first_arrivals(h.candidates, h.trains);
  return h;
}

/// Hears the channel in its whole band and, where that leaves doubt, in the low bands of soft balls. A lower band knows
/// the times less well: it must have more to say.
ChannelDetection select_band(const audio::AudioSource& sound, int channel, const ProgressCallback& progress) {
  ChannelDetection best = detect_channel(sound, channel, progress);
  for (const double rate_hz : kLowBandRates_hz) {
    const int factor = static_cast<int>(sound.rate_hz / rate_hz);
    if (factor < 2 || best.log_odds() > kConclusiveLogOdds) continue;
    ChannelDetection low = detect_channel(audio::decimate(sound, factor), channel, progress);
    if (low.log_odds() > best.log_odds() + kBandSelectionMargin) best = std::move(low);
  }
  return best;
}

/// Standard deviation of the innovations in the quiet tenth: noise without hum and drift.
double noise_rms(const ChannelDetection& h) { return std::sqrt(h.models.noise.quiet_variance); }

NoiseSpectrum noise_spectrum(const ChannelDetection& h) {
  constexpr int kPoints = 256;
  NoiseSpectrum spectrum;
  for (int k = 1; k <= kPoints; ++k) {  // zero is left out: the model takes the difference first
    spectrum.frequency_hz.push_back(0.5 * h.sound.rate_hz * k / kPoints);
    spectrum.psd.push_back(audio::quiet_psd(h.models.noise, h.sound.rate_hz, spectrum.frequency_hz.back()));
  }
  return spectrum;
}

void summarize_tracks(const ChannelDetection& h, RecordingSummary& summary) {
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

void set_status(Detection& d) {
  if (!d.onsets.empty()) {
    d.status = DetectionStatus::ok;
    d.message = std::to_string(d.onsets.size()) + " impacts in " + std::to_string(d.summary.n_drops) +
                (d.summary.n_drops == 1 ? " drop" : " drops");
  } else if (d.summary.n_candidates > 0) {
    d.status = DetectionStatus::too_few_impacts;
    d.message =
        std::to_string(d.summary.n_candidates) +
        " sounds that rise like impacts, but no four of them in intervals that shrink like those of a bouncing ball";
  } else {
    d.status = DetectionStatus::silent;
    d.message = "nothing rises above the noise";
  }
}

std::int64_t count_flag(const Onsets& onsets, Flag flag) {
  return std::count_if(onsets.begin(), onsets.end(), [&](const Onset& onset) { return onset.flags.has(flag); });
}

/// What the user should know of the onsets before he believes them.
/// @param band_rate_hz  sampling rate of the band in which the impacts were heard
std::vector<std::string> warnings_for(const Detection& d, double band_rate_hz) {
  std::vector<std::string> warnings;
  if (d.onsets.empty()) return warnings;
  const std::string of_all = " of " + std::to_string(d.onsets.size()) + " impacts ";
  if (const auto n = count_flag(d.onsets, Flag::clipped); n > 0)
    warnings.push_back(std::to_string(n) + of_all +
                       "are clipped: timed by the wave clipped alike; record with less gain");
  if (const auto n = count_flag(d.onsets, Flag::doubtful); n > 0)
    warnings.push_back(std::to_string(n) + of_all +
                       "may be a cycle of their sound off (flag doubtful, sigma_t_s says how far)");
  if (band_rate_hz < 0.5 * kLowBandRates_hz.front())
    warnings.push_back("the impacts were heard below 500 Hz only: times to a millisecond or two at best");
  else if (band_rate_hz < d.summary.rate_hz)
    warnings.push_back("the impacts were heard below 2 kHz only: times to a fraction of a millisecond at best");
  if (!d.summary.contact_time_at_1_mps_s)
    warnings.push_back(
        "the sound does not tell the contact time: steel's is assumed where the ball sounds as hard, none where it "
        "does not; contact_time_sigma_s says what that leaves open");
  return warnings;
}

template <class SoundOfChannel>
Detection detect_in(const SoundOfChannel& sound_of, int n_channels, const std::string& name,
                    const DetectionConfig& config, const ProgressCallback& progress) {
  if (config.channel && (*config.channel < 0 || *config.channel >= n_channels))
    throw InvalidArgument("channel " + std::to_string(*config.channel) + ": " + name + " has channels 0 to " +
                          std::to_string(n_channels - 1));
  Detection d;
  ChannelDetection best;
  const int first = config.channel.value_or(0);
  const int last = config.channel ? first + 1 : n_channels;
  for (int channel = first; channel < last; ++channel) {
    ChannelDetection h = select_band(sound_of(channel), channel, progress);
    if (channel == first || h.log_odds() > best.log_odds()) best = std::move(h);
  }
  const audio::AudioSource sound = sound_of(best.channel);
  d.summary.rate_hz = sound.rate_hz;
  d.summary.n_channels = n_channels;
  d.summary.channel = best.channel;
  d.summary.channel_reason = config.channel    ? "asked for"
                             : n_channels == 1 ? "the only one"
                                               : "its impacts form the clearest trains";
  d.summary.duration_s = static_cast<double>(sound.n_samples) / sound.rate_hz;
  d.summary.noise_rms = noise_rms(best);
  summarize_tracks(best, d.summary);
  TimedRecording timed = time_recording({best.sound, sound, best.models.noise, best.candidates, best.trains}, name);
  d.onsets = std::move(timed.onsets);
  d.wave = std::move(timed.wave);
  d.summary.contact_time_at_1_mps_s = timed.contact_time_at_1_mps_s;
  d.summary.contact_time_sigma_s = timed.contact_time_sigma_s;
  if (best.models.noise.quiet_variance > 0.0) d.noise = noise_spectrum(best);
  set_status(d);
  d.warnings = warnings_for(d, best.sound.rate_hz);
  return d;
}

}  // namespace

Detection detect(const std::filesystem::path& recording, const DetectionConfig& config,
                 const ProgressCallback& progress) {
  audio::AudioReader reader(recording);
  return detect_in([&](int channel) { return reader.source(channel); }, reader.format().n_channels, recording.string(),
                   config, progress);
}

Detection detect(std::span<const float> samples, double rate_hz, const std::string& name, const DetectionConfig& config,
                 const ProgressCallback& progress) {
  if (!(rate_hz >= kLowestRate_hz && rate_hz <= kHighestRate_hz))
    throw InvalidArgument("sampling rate " + std::to_string(rate_hz) + " Hz: must be 4 kHz to 4 MHz");
  const audio::AudioSource sound = audio::source_in_memory(samples, rate_hz);
  return detect_in([&](int) { return sound; }, 1, name, config, progress);
}

std::vector<Detection> detect(const std::vector<std::filesystem::path>& recordings, const DetectionConfig& config,
                              int n_threads, const ProgressCallback& progress) {
  if (recordings.size() == 1) return {detect(recordings.front(), config, progress)};
  std::vector<Detection> found(recordings.size());
  std::mutex mutex;
  double n_done = 0.0;
  in_parallel(recordings.size(), resolved_threads(n_threads), [&](std::size_t k) {
    try {
      found[k] = detect(recordings[k], config);
    } catch (const FileError& error) {
      found[k].status = DetectionStatus::unreadable;
      found[k].message = error.what();
    }
    const std::lock_guard lock(mutex);
    if (progress) progress(n_done += 1.0, static_cast<double>(recordings.size()));
  });
  return found;
}

}  // namespace bouncelab::detection
