// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/detect.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <system_error>
#include <utility>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "channel_tracks.hpp"
#include "drops/drop_timer.hpp"
#include "tracking/tracking_model.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kBelow500_hz = 2e3;  // sampling rate of a band below which that is all there is
constexpr double kMinRate_hz = 4e3;
constexpr double kMaxRate_hz = 4e6;

NoiseSpectrum noise_spectrum(const BandOfChannel& found) {
  constexpr int kPoints = 256;
  NoiseSpectrum spectrum;
  for (int k = 1; k <= kPoints; ++k) {  // without 0 Hz: the model is one of the differenced signal
    spectrum.frequency_hz.push_back(0.5 * found.sound.rate_hz * k / kPoints);
    spectrum.psd.push_back(quiet_psd(found.models.noise, found.sound.rate_hz, spectrum.frequency_hz.back()));
  }
  return spectrum;
}

void summarize_tracks(const BandOfChannel& band, RecordingSummary& summary) {
  summary.n_candidates = static_cast<std::int64_t>(band.candidates.size());
  summary.n_drops = static_cast<std::int64_t>(band.tracks.size());
  std::vector<double> eps;
  for (const Track& track : band.tracks)
    for (std::size_t k = 1; k + 1 < track.impacts.size(); ++k)
      if (const std::optional<double> eps_of_impact = eps_at(band.candidates, track, k)) eps.push_back(*eps_of_impact);
  if (eps.empty()) return;
  summary.restitution_median = upper_median(std::move(eps));
}

/// Leaves out the drops of fewer impacts, and numbers the others from 0. @return how many were left out
std::size_t leave_out_short(std::int64_t min_impacts, Onsets& onsets, std::vector<Track>& tracks) {
  std::vector<std::int64_t> n_impacts(tracks.size(), 0), number(tracks.size(), 0);
  for (const Onset& onset : onsets) ++n_impacts[static_cast<std::size_t>(onset.drop)];
  const auto is_short = [&](std::size_t drop) { return n_impacts[drop] < min_impacts; };
  std::vector<Track> kept;
  for (std::size_t drop = 0; drop < tracks.size(); ++drop) {
    number[drop] = std::ssize(kept);
    if (!is_short(drop)) kept.push_back(std::move(tracks[drop]));
  }
  std::erase_if(onsets, [&](const Onset& onset) { return is_short(static_cast<std::size_t>(onset.drop)); });
  for (Onset& onset : onsets) onset.drop = number[static_cast<std::size_t>(onset.drop)];
  const std::size_t n_left_out = tracks.size() - kept.size();
  tracks = std::move(kept);
  return n_left_out;
}

std::vector<DropSummary> summarize_drops(const Onsets& onsets, const std::vector<Track>& tracks) {
  std::vector<DropSummary> drops(tracks.size());
  for (std::size_t k = 0; k < tracks.size(); ++k)
    drops[k].odds = tracks[k].log_odds < log(kMostOdds) ? exp(tracks[k].log_odds) : kMostOdds;
  for (const Onset& onset : onsets) {
    DropSummary& drop = drops[static_cast<std::size_t>(onset.drop)];
    if (drop.n_impacts++ == 0) drop.begin_s = onset.t_s;
  }
  return drops;
}

/// What was heard where no drop was found.
/// @param n_short  drops that were left out
Note nothing_found(std::size_t n_short, std::int64_t min_impacts, std::size_t n_candidates) {
  const auto n = static_cast<double>(n_candidates);
  if (n_short > 0) return {NoteKind::drops_too_short, {static_cast<double>(n_short), static_cast<double>(min_impacts)}};
  if (n_candidates == 0) return {NoteKind::silence};
  return {n_candidates < 3 ? NoteKind::no_three_bounces : NoteKind::sounds_not_of_ball, {n}};
}

std::int64_t count_flag(const Onsets& onsets, Flag flag) {
  return std::count_if(onsets.begin(), onsets.end(), [&](const Onset& onset) { return onset.flags.has(flag); });
}

struct OneOfSeveral {
  std::int64_t drop = 0;
  double begin_s = 0.0, end_s = 0.0;
  std::vector<double> eps;  ///< of impacts whose neighbours were found
};

/// The drops of the first balls that bounce at the same time, if any do.
std::optional<Note> balls_at_once(const Onsets& onsets) {
  std::vector<OneOfSeveral> drops;
  for (std::size_t k = 0; k < onsets.size(); ++k) {
    const Onset& onset = onsets[k];
    if (drops.empty() || drops.back().drop != onset.drop) drops.push_back({onset.drop, onset.t_s, 0.0, {}});
    drops.back().end_s = onset.t_s;
    if (k + 1 < onsets.size() && onset.t_s > drops.back().begin_s && onsets[k + 1].drop == onset.drop &&
        onsets[k + 1].impact - onsets[k - 1].impact == 2)
      drops.back().eps.push_back((onsets[k + 1].t_s - onset.t_s) / (onset.t_s - onsets[k - 1].t_s));
  }
  const auto is_at_once = [](const OneOfSeveral& a, const OneOfSeveral& b) {
    return a.drop != b.drop && a.begin_s < b.end_s && b.begin_s < a.end_s;
  };
  const auto first = std::find_if(drops.begin(), drops.end(), [&](const OneOfSeveral& drop) {
    return std::any_of(drops.begin(), drops.end(), [&](const auto& other) { return is_at_once(drop, other); });
  });
  if (first == drops.end()) return {};
  double n = 0.0;
  std::string values;
  for (const OneOfSeveral& drop : drops) {
    if (&drop != &*first && !is_at_once(drop, *first)) continue;
    n += 1.0;
    if (drop.eps.empty()) continue;
    values += (values.empty() ? "" : ", ") +
              formatted("ε = %.3f (drop %lld)", upper_median(drop.eps), static_cast<long long>(drop.drop));
  }
  return Note{NoteKind::balls_at_once, {n, first->begin_s}, values};
}

/// Limits of the onsets' accuracy.
std::vector<Note> limits_of(const Detection& d, const BandOfChannel& found, bool is_timed_in_full_band) {
  std::vector<Note> notes;
  const auto is_in_drop = [&](const audio::Silence& gap) {
    for (std::size_t k = 1; k < d.onsets.size(); ++k)
      if (d.onsets[k].drop == d.onsets[k - 1].drop && d.onsets[k - 1].t_s < gap.end_s && d.onsets[k].t_s > gap.begin_s)
        return true;
    return false;
  };
  if (const auto n = std::count_if(found.sound.silences.begin(), found.sound.silences.end(), is_in_drop); n > 0)
    notes.push_back({NoteKind::gaps_of_time, {static_cast<double>(n)}});
  const auto n_all = static_cast<double>(d.onsets.size());
  for (const auto& [flag, kind] :
       {std::pair{Flag::clipped, NoteKind::clipped}, std::pair{Flag::improbable, NoteKind::improbable_impacts},
        std::pair{Flag::doubtful, NoteKind::several_places}})
    if (const auto n = count_flag(d.onsets, flag); n > 0) notes.push_back({kind, {static_cast<double>(n), n_all}});
  if (!is_timed_in_full_band)
    notes.push_back({NoteKind::low_band, {found.sound.rate_hz < kBelow500_hz ? 500.0 : 2000.0}});
  return notes;
}

/// @param channels    sources that may be read by several threads where n_threads is not 1
/// @param with_sound  those of them that a ball may be heard in; where there are none, the first is as good as any
Detection detect_in(const std::vector<audio::AudioSource>& channels, std::vector<int> with_sound,
                    const std::string& name, const DetectionConfig& config, int n_threads,
                    const ProgressCallback& progress) {
  const auto n_channels = static_cast<int>(channels.size());
  check_options(config);
  for (const auto& [what, value] :
       {std::pair{"gravity_mps2 ", config.gravity_mps2}, {"drop_height_m ", config.drop_height_m.value_or(1.0)}})
    if (!(value > 0.0 && std::isfinite(value)))
      throw InvalidArgument(what + std::to_string(value) + ": must be above 0 and finite");
  if (config.channel && (*config.channel < 0 || *config.channel >= n_channels))
    throw InvalidArgument("channel " + std::to_string(*config.channel) + ": " + name + " has channels 0 to " +
                          std::to_string(n_channels - 1));
  const std::string channel_reason = config.channel           ? "asked for"
                                     : n_channels == 1        ? "the only one"
                                     : with_sound.empty()     ? "none has sound"
                                     : with_sound.size() == 1 ? "the only one with sound"
                                                              : "its impacts are the most probable and rise the most";
  if (config.channel || with_sound.empty()) with_sound = {config.channel.value_or(0)};
  std::vector<audio::AudioSource> searched;
  std::vector<double> begin_s;
  for (const int channel : with_sound) {
    audio::PartOfSource part = audio::without_zeros_around(channels[static_cast<std::size_t>(channel)]);
    searched.push_back(std::move(part.sound));
    begin_s.push_back(part.begin_s);
  }
  std::optional<double> elastic_flight_s;
  if (config.drop_height_m) elastic_flight_s = std::sqrt(8.0 * *config.drop_height_m / config.gravity_mps2);
  SearchedChannel best = choose_channel(searched, elastic_flight_s, n_threads, progress);
  const audio::AudioSource& sound = searched[best.channel];
  BandOfChannel& band = best.bands[best.best];
  Detection d;
  d.summary.rate_hz = sound.rate_hz;
  d.summary.n_channels = n_channels;
  d.summary.channel = with_sound[best.channel];
  d.summary.channel_reason = channel_reason;
  d.summary.n_gaps = static_cast<int>(sound.silences.size());
  d.summary.duration_s = static_cast<double>(channels.front().n_samples) / sound.rate_hz;
  d.summary.noise_rms = std::sqrt(band.models.noise.quiet_variance);
  std::vector<double> impacts_s;
  for (const Track& track : band.tracks)
    for (const TrackImpact& impact : track.impacts) impacts_s.push_back(band.candidates[impact.candidate].t_s);
  const ClippingLimits limits = find_clipping_limits(sound, impacts_s);
  const auto drops_of = [&](const BandOfChannel& of) {
    return BandOfDrops{.sound = of.sound,
                       .whole = of.decimation == 1 ? std::nullopt : std::optional(sound),
                       .noise = of.models.noise,
                       .candidates = of.candidates,
                       .tracks = of.tracks,
                       .limits = limits,
                       .recorded_rms_hz = {}};
  };
  std::vector<BandOfDrops> other_bands;
  const auto add_other = [&](const BandOfChannel& other) {
    if (!other.tracks.empty()) other_bands.push_back(drops_of(other));
  };
  for (std::size_t b = best.best; b-- > 0;) add_other(best.bands[b]);  // what is nearest is added first
  for (std::size_t b = best.best + 1; b < best.bands.size(); ++b) add_other(best.bands[b]);
  TimedRecording timed = time_recording(drops_of(band), other_bands, config.gravity_mps2, n_threads, name);
  d.onsets = std::move(timed.onsets);
  const std::size_t n_short = leave_out_short(config.min_impacts, d.onsets, band.tracks);
  d.drops = summarize_drops(d.onsets, band.tracks);
  summarize_tracks(band, d.summary);
  if (!d.onsets.empty()) {
    d.wave = std::move(timed.wave);
    d.summary.contact_time_at_1_mps_s = timed.contact_time_at_1_mps_s;
    d.summary.contact_time_sigma_s = timed.contact_time_sigma_s;
  }
  if (band.models.noise.quiet_variance > 0.0) d.noise = noise_spectrum(band);
  if (d.onsets.empty()) {
    d.status = band.candidates.empty() ? DetectionStatus::silent : DetectionStatus::too_few_impacts;
    d.notes = {nothing_found(n_short, config.min_impacts, band.candidates.size())};
  } else {
    d.status = DetectionStatus::ok;
    d.notes = limits_of(d, band, timed.is_full_band);
  }
  const double moved_s = begin_s[best.channel];
  for (Onset& onset : d.onsets) onset.t_s += moved_s;
  for (DropSummary& drop : d.drops) drop.begin_s += moved_s;
  if (std::optional<Note> several = balls_at_once(d.onsets)) d.notes.push_back(std::move(*several));
  return d;
}

/// What the recording is, and what follows from that for its times.
void describe_format(const audio::AudioFormat& format, const std::string& coding_before, Detection& d) {
  const std::string& coding = format.lossy_coding.empty() ? coding_before : format.lossy_coding;
  d.summary.format = format.description;
  d.summary.lossy_coding = coding;
  d.summary.ffmpeg = format.ffmpeg;
  if (!coding.empty() && !d.onsets.empty()) d.notes.push_back({NoteKind::lossy_coding, {}, coding});
  if (!format.warning.empty()) d.notes.push_back({NoteKind::of_file, {}, format.warning});
}

Detection detect_track(const audio::AudioReader& sound, const std::string& name, const DetectionConfig& config,
                       int n_threads, const ProgressCallback& progress) {
  const int n_here = kMayStartChildBesideThreads ? n_threads : 1;
  std::vector<audio::AudioSource> channels;
  const int n_channels = sound.format().n_channels;
  // of this recording alone: others beside it may have that channel
  if (config.channel && *config.channel >= n_channels)
    throw FileError(name, "has no channel " + std::to_string(*config.channel) + ", only 0 to " +
                              std::to_string(n_channels - 1) + "; choose another (--channel)");
  for (int c = 0; c < n_channels; ++c) channels.push_back(sound.source(c));
  // each takes a pass over all: of the many channels of an interface most have nothing plugged in
  std::vector<int> with_sound{0};
  if (n_channels > 1 && !config.channel) with_sound = sound.channels_with_sound();
  Detection d = detect_in(channels, std::move(with_sound), name, config, n_here, progress);
  d.summary.n_tracks = sound.format().n_tracks;
  d.summary.track = sound.format().track;
  describe_format(sound.format(), config.lossy_coding, d);
  return d;
}

/// How likely it is that what was found are drops: the sum of their log odds.
double log_odds_of(const Detection& d) {
  double sum = 0.0;
  for (const DropSummary& drop : d.drops) sum += log(drop.odds);
  return sum;
}

Detection detect_file(const std::filesystem::path& recording, const DetectionConfig& config, int n_threads,
                      const ProgressCallback& progress) {
  const std::string name = input_name(recording);
  const audio::AudioReader first(recording, config.rate_hz, config.track.value_or(0));
  Detection best = detect_track(first, name, config, n_threads, progress);
  const int n_tracks = first.format().n_tracks;
  if (config.track || n_tracks == 1) return best;
  for (int track = 1; track < n_tracks; ++track) {
    const audio::AudioReader sound(recording, config.rate_hz, track);
    Detection d = detect_track(sound, name, config, n_threads, progress);
    if (log_odds_of(d) > log_odds_of(best)) best = std::move(d);
  }
  if (!best.onsets.empty())
    best.notes.push_back(
        {NoteKind::track_taken, {static_cast<double>(best.summary.track), static_cast<double>(n_tracks)}});
  return best;
}

/// A long recording that began last would keep one thread busy and all others waiting.
std::vector<std::size_t> largest_first(const std::vector<std::filesystem::path>& recordings) {
  std::vector<std::uintmax_t> n_bytes;
  for (const auto& recording : recordings) {
    std::error_code unreadable;
    const std::uintmax_t n = std::filesystem::file_size(recording, unreadable);
    n_bytes.push_back(unreadable ? 0 : n);
  }
  std::vector<std::size_t> order(recordings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return n_bytes[a] > n_bytes[b]; });
  return order;
}

}  // namespace

Description members_of(const DetectionConfig*) {
  using C = DetectionConfig;
  static constexpr Member options[]{
      member<&C::channel>("channel", "Channel, from 0; -1 = the one in which impacts are detected best")
          .within(-1, 1023)
          .unknown_as("-1"),
      member<&C::track>("track", "Track of sound in a video, from 0; -1 = the one in which a ball is heard best")
          .within(-1, 1023)
          .unknown_as("-1"),
      member<&C::rate_hz>("rate", "Sampling rate [Hz] of numbers (.npy, .csv) that come without times; 0 = none")
          .within(0.0, kMaxRate_hz)
          .unknown_as("0"),
      member<&C::min_impacts>("min_impacts", "Drops of fewer impacts are left out").within(3, 1'000'000)};
  return options;
}

const RecordingDetection* first_found(const std::vector<RecordingDetection>& recordings) {
  const auto found = std::find_if(recordings.begin(), recordings.end(), [](const auto& r) { return r.n_onsets > 0; });
  return found == recordings.end() ? nullptr : &*found;
}

Detection detect(const std::filesystem::path& recording, const DetectionConfig& config,
                 const ProgressCallback& progress) {
  return detect_file(recording, config, 1, progress);
}

Detection detect(std::span<const float> samples, double rate_hz, const std::string& name, const DetectionConfig& config,
                 const ProgressCallback& progress, int n_channels) {
  if (!(rate_hz >= kMinRate_hz && rate_hz <= kMaxRate_hz))
    throw InvalidArgument("sampling rate " + std::to_string(rate_hz) + " Hz: must be 4 kHz to 4 MHz");
  const auto n = static_cast<std::size_t>(n_channels);
  if (n_channels < 1 || samples.size() % n != 0)
    throw InvalidArgument(std::to_string(samples.size()) + " samples are none of " + std::to_string(n_channels) +
                          " channels");
  std::vector<audio::AudioSource> channels;
  std::vector<int> with_sound;
  for (std::size_t c = 0; c < n; ++c) {
    channels.push_back(audio::source_in_memory(samples, rate_hz, n_channels, static_cast<int>(c)));
    std::size_t k = c;
    while (k < samples.size() && samples[k] == samples[c]) k += n;
    if (n == 1 || k < samples.size()) with_sound.push_back(static_cast<int>(c));
  }
  Detection d = detect_in(channels, std::move(with_sound), name, config, 1, progress);
  describe_format({}, config.lossy_coding, d);
  return d;
}

void detect_each(const std::vector<std::filesystem::path>& recordings, const DetectionConfig& config, int n_threads,
                 const DetectionSink& sink, const ProgressCallback& progress) {
  if (recordings.size() == 1) return sink(0, detect_file(recordings.front(), config, n_threads, progress));
  std::mutex mutex;
  double n_done = 0.0;
  const std::vector<std::size_t> order = largest_first(recordings);
  parallel_for(recordings.size(), kMayStartChildBesideThreads ? n_threads : 1, [&](std::size_t i) {
    const std::size_t k = order[i];
    Detection found;
    try {
      // on the same threads, where others have nothing to do
      found = detect_file(recordings[k], config, n_threads, {});
    } catch (const FileError& error) {
      found.status = DetectionStatus::unreadable;
      found.notes = {{NoteKind::recording_left_out, {}, error.what()}};
    }
    const std::lock_guard lock(mutex);
    sink(k, std::move(found));
    if (progress) progress(n_done += 1.0, static_cast<double>(recordings.size()));
  });
}

std::vector<Detection> detect(const std::vector<std::filesystem::path>& recordings, const DetectionConfig& config,
                              int n_threads, const ProgressCallback& progress) {
  std::vector<Detection> found(recordings.size());
  detect_each(
      recordings, config, n_threads, [&](std::size_t k, Detection&& d) { found[k] = std::move(d); }, progress);
  return found;
}

}  // namespace bouncelab::detection
