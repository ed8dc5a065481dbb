// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/analyze.hpp"

#include <memory>
#include <utility>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/files.hpp"

namespace bouncelab::loop {
namespace {

/// @param rate_hz  of numbers without a sampling rate
audio::AudioSource sound_of_file(const detection::RecordingDetection& r, std::optional<double> rate_hz) {
  const auto reader = std::make_shared<audio::AudioReader>(r.recording, rate_hz, r.found.summary.track);
  audio::AudioSource sound = reader->source(r.found.summary.channel);
  sound.read = [reader, read = std::move(sound.read)](std::int64_t first, std::span<float> out) { read(first, out); };
  return sound;
}

std::vector<RecordingDetails> details_of(const Analysis& analysis, const AnalyzeConfig& config,
                                         const SoundOf& sound_of) {
  std::vector<RecordingDetails> all;
  std::int64_t n_shown = 0;
  for (const detection::RecordingDetection& r : analysis.recordings) {
    if (r.n_onsets == 0 || n_shown >= kMostShown) continue;
    const detection::Detection& d = r.found;
    const std::string name = input_name(r.recording);
    RecordingDetails details{r.recording, d.summary.n_drops, {}, d.wave, d.noise};
    const audio::AudioSource sound = sound_of(r);
    for (std::int64_t drop = 0; drop < d.summary.n_drops && n_shown < kMostShown; ++drop, ++n_shown)
      details.drops.push_back({detection::drop_preview(sound, name, d.summary.channel, d.onsets, drop),
                               fit::predict_intervals(analysis.restitution.samples, name, drop, analysis.fit.law.law,
                                                      config.restitution.gravity_mps2)});
    all.push_back(std::move(details));
  }
  return all;
}

}  // namespace

detection::DetectionConfig detection_config(const AnalyzeConfig& config) {
  detection::DetectionConfig detection = config.detection;
  detection.gravity_mps2 = config.restitution.gravity_mps2;
  detection.drop_height_m = config.restitution.drop_height_m;
  return detection;
}

std::vector<detection::RecordingDetection> detect_all(const std::vector<std::filesystem::path>& files,
                                                      const detection::DetectionConfig& config, int n_threads,
                                                      bool with_details, const ProgressCallback& progress) {
  std::vector<detection::RecordingDetection> recordings(files.size());
  const auto take = [&](std::size_t k, detection::Detection&& found) {
    recordings[k] = {files[k].string(), found.onsets.size(), std::move(found)};
    if (with_details) return;
    recordings[k].found.wave.reset();
    recordings[k].found.noise.reset();
  };
  detection::detect_each(files, config, n_threads, take, progress);
  return recordings;
}

Analysis analyze(const std::vector<std::filesystem::path>& recordings, const AnalyzeConfig& config,
                 const StageProgress& progress) {
  const auto sound_of = [&](const detection::RecordingDetection& r) {
    return sound_of_file(r, config.detection.rate_hz);
  };
  return analyze_found(detect_all(recordings, detection_config(config), config.n_threads, config.with_details,
                                  progress("detect", recordings.size() == 1 ? "s of sound" : "recordings")),
                       config, sound_of, progress);
}

Analysis analyze_times(Onsets onsets, const AnalyzeConfig& config, const StageProgress& progress) {
  Analysis analysis;
  analysis.onsets = std::move(onsets);
  analysis.restitution = fit::restitution_samples(analysis.onsets, config.restitution);
  analysis.fit = fit::fit_all(analysis.restitution.samples, config.fit, progress("fit", "fits"));
  return analysis;
}

Analysis analyze_samples(RestitutionSamples samples, const AnalyzeConfig& config, const StageProgress& progress) {
  Analysis analysis;
  analysis.restitution.counts.n_samples = samples.size();
  analysis.restitution.samples = std::move(samples);
  analysis.fit = fit::fit_all(analysis.restitution.samples, config.fit, progress("fit", "fits"));
  return analysis;
}

Analysis analyze_found(std::vector<detection::RecordingDetection> recordings, const AnalyzeConfig& config,
                       const SoundOf& sound_of, const StageProgress& progress) {
  Onsets onsets;
  for (const detection::RecordingDetection& r : recordings)
    onsets.insert(onsets.end(), r.found.onsets.begin(), r.found.onsets.end());
  Analysis analysis;
  if (!onsets.empty()) analysis = analyze_times(std::move(onsets), config, progress);
  analysis.recordings = std::move(recordings);
  const detection::RecordingDetection* const shown = first_found(analysis.recordings);
  if (!shown) return analysis;
  analysis.wave = detection::wave_preview(sound_of(*shown), input_name(shown->recording), shown->found.summary.channel,
                                          shown->found.onsets);
  if (config.with_details) analysis.details = details_of(analysis, config, sound_of);
  return analysis;
}

Description members_of(const DropDetails*) {
  using D = DropDetails;
  static constexpr Member all[]{
      computed(
          "", [](const D& d) { return std::get<Object>(value_of(d.preview)); }, "As wave.json"),
      computed(
          "intervals", [](const D& d) { return as_lists(d.intervals); },
          "Lists `impact`, `found_s`, `expected_s`, `sigma_s`")};
  return all;
}

Description members_of(const RecordingDetails*) {
  using R = RecordingDetails;
  static constexpr Member all[]{
      computed(
          "recording", [](const R& r) { return input_name(r.recording); }, "As it was given"),
      member<&R::n_drops>("n_drops", "In the recording; not all need be in `drops`"),
      member<&R::drops>("drops", "Each as wave.json, and `intervals`"),
      member<&R::wave>("wave", "Learned template: `t0_s`, `dt_s`, `mean`, `spread`, `n_impacts`")
          .left_out_where_unknown(),
      member<&R::noise>("noise", "`frequency_hz`, `psd` in 1/Hz").left_out_where_unknown()};
  return all;
}

Description members_of(const Analysis*) {
  using A = Analysis;
  static constexpr Member all[]{
      computed(
          "", [](const A& a) { return std::get<Object>(value_of(a.restitution.counts)); }, "What was counted"),
      member<&A::recordings>("recordings", "As `detect --json`")};
  return all;
}

}  // namespace bouncelab::loop
