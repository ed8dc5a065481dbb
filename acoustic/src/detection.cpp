// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/acoustic/detection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "autoregression.hpp"
#include "bouncelab/acoustic/audio_reader.hpp"
#include "bouncelab/core/error.hpp"
#include "candidates.hpp"
#include "impact_timing.hpp"
#include "train_timing.hpp"
#include "trains.hpp"

namespace bouncelab {
namespace {

// enough poles for the loudest twenty-odd modes of a plate; more buys nothing on noise
constexpr int kOrder = 48;

/// What one channel has to say.
struct Hearing {
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
  h.channel = channel;
  h.models = learn_sound_models(sound, kOrder);
  h.candidates = find_candidates(sound, h.models.all, progress);
  h.trains = find_trains(h.candidates, 2.0 / sound.rate_hz);
  return h;
}

/// Standard deviation of what is left in the quiet tenth after hum and drift.
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

Onsets time_all(const Hearing& h, const Sound& sound, const std::string& name) {
  std::vector<RoughImpact> rough;
  for (const Train& train : h.trains)
    for (const TrainImpact& impact : train.impacts) {
      const Candidate& c = h.candidates[impact.candidate];
      rough.push_back({c.t_s, c.amplitude, c.reach_s});
    }
  const std::optional<ImpactWave> wave = learn_impact_wave(sound, h.models.noise, rough);
  Onsets onsets;
  for (std::size_t drop = 0; drop < h.trains.size(); ++drop) {
    const double end_s = drop + 1 < h.trains.size() ? h.candidates[h.trains[drop + 1].impacts.front().candidate].t_s
                                                    : static_cast<double>(sound.n_samples) / sound.rate_hz;
    for (const TrainOnset& onset :
         wave ? time_train(sound, *wave, h.trains[drop], h.candidates, end_s) : rough_onsets(h, h.trains[drop]))
      onsets.push_back(to_onset(onset, static_cast<std::int64_t>(drop), name));
  }
  return onsets;
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
    Hearing h = hear(sound_of(channel), channel, progress);
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
  d.onsets = time_all(best, sound, name);
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
