// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/acoustic/wave_preview.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/acoustic/audio_reader.hpp"

namespace bouncelab {
namespace {

constexpr std::int64_t kColumns = 2000;  // wider than the picture on any screen it is drawn on
constexpr double kBefore_s = 3e-3;
constexpr double kAfter_s = 8e-3;

void fill_envelope(const Sound& sound, WavePreview& preview) {
  const std::int64_t n_columns = std::min(kColumns, sound.n_samples);
  std::vector<float> block;
  for (std::int64_t c = 0; c < n_columns; ++c) {
    const std::int64_t first = c * sound.n_samples / n_columns;
    const std::int64_t last = (c + 1) * sound.n_samples / n_columns;
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

WaveExcerpt excerpt_around(const Sound& sound, const Onset& centre, const Onsets& marks) {
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

}  // namespace

WavePreview wave_preview(const Sound& sound, const std::string& recording, int channel, const Onsets& onsets) {
  WavePreview preview;
  preview.recording = recording;
  preview.rate_hz = sound.rate_hz;
  preview.channel = channel;
  preview.duration_s = static_cast<double>(sound.n_samples) / sound.rate_hz;
  fill_envelope(sound, preview);
  std::copy_if(onsets.begin(), onsets.end(), std::back_inserter(preview.marks),
               [&](const Onset& onset) { return onset.recording == recording; });
  // early, middle and late of the first drop: the later ones look alike
  std::vector<std::size_t> first_drop;
  for (std::size_t k = 0; k < preview.marks.size(); ++k)
    if (preview.marks[k].drop == preview.marks.front().drop) first_drop.push_back(k);
  std::size_t previous = onsets.size();
  for (const double part : {0.0, 1.0 / 3, 2.0 / 3, 1.0}) {
    if (first_drop.empty()) break;
    const std::size_t k = first_drop[static_cast<std::size_t>(part * static_cast<double>(first_drop.size() - 1))];
    if (k == previous) continue;
    preview.excerpts.push_back(excerpt_around(sound, preview.marks[k], preview.marks));
    previous = k;
  }
  return preview;
}

WavePreview wave_preview(const std::filesystem::path& recording, int channel, const Onsets& onsets) {
  AudioReader reader(recording);
  return wave_preview(reader.sound(channel), recording.string(), channel, onsets);
}

}  // namespace bouncelab
