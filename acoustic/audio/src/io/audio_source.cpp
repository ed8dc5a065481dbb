// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/audio_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "io/not_finite.hpp"

namespace bouncelab::audio {

AudioSource source_in_memory(std::span<const float> samples, double rate_hz) {
  if (!(rate_hz > 0.0) || !std::isfinite(rate_hz))
    throw InvalidArgument("sampling rate " + std::to_string(rate_hz) + " Hz: must be finite and positive");
  if (const std::size_t bad = first_not_finite(samples); bad < samples.size())
    throw InvalidArgument("sample " + std::to_string(bad) + " is not a finite number; remove or repair it");
  return {rate_hz, static_cast<std::int64_t>(samples.size()), [samples](std::int64_t first, std::span<float> out) {
            std::copy_n(samples.begin() + first, out.size(), out.begin());
          }};
}

AudioSource one_at_a_time(AudioSource source, std::shared_ptr<std::mutex> reading) {
  source.read = [read = std::move(source.read), reading](std::int64_t first, std::span<float> out) {
    const std::lock_guard lock(*reading);
    read(first, out);
  };
  return source;
}

void read_padded(const AudioSource& source, std::int64_t first, std::span<float> out) {
  const std::int64_t last = first + static_cast<std::int64_t>(out.size());
  const std::int64_t lo = std::clamp<std::int64_t>(0, first, last);
  const std::int64_t hi = std::clamp<std::int64_t>(source.n_samples, lo, last);
  std::fill(out.begin(), out.begin() + (lo - first), 0.0F);
  std::fill(out.begin() + (hi - first), out.end(), 0.0F);
  if (hi > lo) source.read(lo, out.subspan(lo - first, hi - lo));
}

}  // namespace bouncelab::audio
