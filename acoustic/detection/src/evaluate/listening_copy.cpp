// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "bouncelab/audio/dsp/decimate.hpp"
#include "bouncelab/detection/wave_preview.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kMargin_s = 0.5;
constexpr double kLongest_s = 30.0;       // 1.4 MB of 16 bit at 24 kHz: what a report may weigh more
constexpr double kHighestRate_hz = 24e3;  // clicks are told by ear up to some 10 kHz
constexpr double kPeak = 0.9;

}  // namespace

ListeningCopy listening_copy(const audio::AudioSource& sound, const Onsets& marks) {
  if (marks.empty() || sound.n_samples <= 0) return {};
  const auto [first_mark, last_mark] =
      std::minmax_element(marks.begin(), marks.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  const double begin_s = std::max(0.0, first_mark->t_s - kMargin_s);
  const double end_s = std::min(last_mark->t_s + kMargin_s, begin_s + kLongest_s);
  const auto factor = static_cast<int>(std::ceil(sound.rate_hz / kHighestRate_hz));
  const audio::AudioSource heard = factor > 1 ? audio::decimate(sound, factor) : sound;
  const auto sample_at = [&](double t_s) {
    return std::clamp<std::int64_t>(std::llround(t_s * heard.rate_hz), 0, heard.n_samples);
  };
  const std::int64_t begin = sample_at(begin_s);
  std::vector<float> samples(static_cast<std::size_t>(std::max<std::int64_t>(0, sample_at(end_s) - begin)));
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

}  // namespace bouncelab::detection
