// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/wave_preview.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::int64_t kColumns = 2000;  // wider than the picture on any screen it is drawn on
constexpr double kBefore_s = 3e-3;
constexpr double kAfter_s = 8e-3;

// of a listening copy
constexpr double kMargin_s = 0.5;
constexpr double kLongest_s = 30.0;       // 1.4 MB of 16 bit at 24 kHz: what a report may weigh more
constexpr double kHighestRate_hz = 24e3;  // clicks are told by ear up to some 10 kHz
constexpr double kPeak = 0.9;

std::int64_t sample_at(const audio::AudioSource& sound, double t_s) {
  return std::clamp<std::int64_t>(std::llround(t_s * sound.rate_hz), 0, sound.n_samples);
}

/// Extremes of the samples begin ... end - 1 in columns.
void fill_envelope(const audio::AudioSource& sound, std::int64_t begin, std::int64_t end, WavePreview& preview) {
  const std::int64_t n = end - begin, n_columns = std::min(kColumns, n);
  std::vector<float> block;
  for (std::int64_t c = 0; c < n_columns; ++c) {
    const std::int64_t first = begin + c * n / n_columns;
    const std::int64_t last = begin + (c + 1) * n / n_columns;
    float lo = INFINITY;
    float hi = -INFINITY;
    for (std::int64_t at = first; at < last;) {  // a column of an hours-long recording is read in pieces
      block.resize(static_cast<std::size_t>(std::min<std::int64_t>(last - at, 1 << 16)));
      sound.read(at, block);
      const auto [least, greatest] = std::minmax_element(block.begin(), block.end());
      lo = std::min(lo, *least);
      hi = std::max(hi, *greatest);
      at += static_cast<std::int64_t>(block.size());
    }
    preview.column_t_s.push_back(0.5 * static_cast<double>(first + last - 1) / sound.rate_hz);
    preview.lo.push_back(lo);
    preview.hi.push_back(hi);
  }
}

WaveExcerpt excerpt_around(const audio::AudioSource& sound, const Onset& centre, const Onsets& marks) {
  const auto first = std::max<std::int64_t>(0, std::llround((centre.t_s - kBefore_s) * sound.rate_hz));
  const auto last = std::min<std::int64_t>(sound.n_samples, std::llround((centre.t_s + kAfter_s) * sound.rate_hz));
  WaveExcerpt excerpt;
  excerpt.title = "drop " + std::to_string(centre.drop) + ", impact " + std::to_string(centre.impact);
  excerpt.t0_s = static_cast<double>(first) / sound.rate_hz;
  excerpt.dt_s = 1.0 / sound.rate_hz;
  std::vector<float> samples(static_cast<std::size_t>(std::max<std::int64_t>(0, last - first)));
  if (!samples.empty()) sound.read(first, samples);
  excerpt.samples.assign(samples.begin(), samples.end());
  const double end_s = static_cast<double>(last) / sound.rate_hz;
  for (const Onset& mark : marks)
    if (mark.t_s >= excerpt.t0_s && mark.t_s <= end_s) excerpt.marks.push_back({mark.t_s, mark.sigma_t_s, mark.impact});
  return excerpt;
}

/// Early, middle and late ones of one drop.
void add_excerpts(const audio::AudioSource& sound, const Onsets& of_drop, const Onsets& marks, WavePreview& preview) {
  if (of_drop.empty()) return;
  std::size_t previous = of_drop.size();
  for (const double part : {0.0, 1.0 / 3, 2.0 / 3, 1.0}) {
    const auto k = static_cast<std::size_t>(part * static_cast<double>(of_drop.size() - 1));
    if (k == previous) continue;
    preview.excerpts.push_back(excerpt_around(sound, of_drop[k], marks));
    previous = k;
  }
}

Onsets only(const Onsets& onsets, const std::string& recording, std::optional<std::int64_t> drop) {
  Onsets chosen;
  std::copy_if(onsets.begin(), onsets.end(), std::back_inserter(chosen),
               [&](const Onset& onset) { return onset.recording == recording && (!drop || onset.drop == *drop); });
  return chosen;
}

WavePreview preview_of(const audio::AudioSource& sound, const std::string& recording, int channel) {
  WavePreview preview;
  preview.recording = recording;
  preview.rate_hz = sound.rate_hz;
  preview.channel = channel;
  preview.duration_s = static_cast<double>(sound.n_samples) / sound.rate_hz;
  return preview;
}

}  // namespace

ListeningCopy listening_copy(const audio::AudioSource& sound, const Onsets& marks) {
  if (marks.empty() || sound.n_samples <= 0) return {};
  const auto [first_mark, last_mark] =
      std::minmax_element(marks.begin(), marks.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  const double begin_s = std::max(0.0, first_mark->t_s - kMargin_s);
  const double end_s = std::min(last_mark->t_s + kMargin_s, begin_s + kLongest_s);
  const auto factor = static_cast<int>(std::ceil(sound.rate_hz / kHighestRate_hz));
  const audio::AudioSource heard = factor > 1 ? decimate(sound, factor) : sound;
  const std::int64_t begin = sample_at(heard, begin_s), end = sample_at(heard, end_s);
  std::vector<float> samples(static_cast<std::size_t>(std::max<std::int64_t>(0, end - begin)));
  if (samples.empty()) return {};
  heard.read(begin, samples);
  float peak = 0.0F;
  for (const float x : samples) peak = std::max(peak, std::abs(x));
  if (!(peak > 0.0F)) return {};
  ListeningCopy copy{static_cast<double>(begin) / heard.rate_hz, heard.rate_hz, {}};
  copy.samples.reserve(samples.size());
  for (const float x : samples)
    copy.samples.push_back(static_cast<std::int16_t>(std::lround(32767.0 * kPeak * static_cast<double>(x / peak))));
  return copy;
}

WavePreview wave_preview(const audio::AudioSource& sound, const std::string& recording, int channel,
                         const Onsets& onsets) {
  WavePreview preview = preview_of(sound, recording, channel);
  fill_envelope(sound, 0, sound.n_samples, preview);
  preview.marks = only(onsets, recording, std::nullopt);
  preview.copy = listening_copy(sound, preview.marks);
  // excerpts of the first drop: the later ones look alike
  if (!preview.marks.empty())
    add_excerpts(sound, only(preview.marks, recording, preview.marks.front().drop), preview.marks, preview);
  return preview;
}

WavePreview drop_preview(const audio::AudioSource& sound, const std::string& recording, int channel,
                         const Onsets& onsets, std::int64_t drop) {
  WavePreview preview = preview_of(sound, recording, channel);
  preview.marks = only(onsets, recording, drop);
  if (preview.marks.empty())
    throw InvalidArgument("drop " + std::to_string(drop) + ": " + recording + " has no such drop");
  const double first_s = preview.marks.front().t_s, last_s = preview.marks.back().t_s;
  const double margin_s = std::clamp(0.1 * (last_s - first_s), 0.01, 0.5);
  fill_envelope(sound, sample_at(sound, first_s - margin_s), sample_at(sound, last_s + margin_s), preview);
  add_excerpts(sound, preview.marks, preview.marks, preview);
  return preview;
}

WavePreview wave_preview(const std::filesystem::path& recording, int channel, const Onsets& onsets,
                         std::optional<double> rate_hz, int track) {
  audio::AudioReader reader(recording, rate_hz, track);
  return wave_preview(reader.source(channel), input_name(recording), channel, onsets);
}

}  // namespace bouncelab::detection
