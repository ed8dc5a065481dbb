// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/audio_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

/// By the bits: the exponent of what is not finite is all ones, and of samples from 2^40 on the squares' sums would not
/// be finite.
bool is_usable(float x) {
  constexpr std::uint32_t kExponent = 0x7f800000, kExponentOfMost = (127U + 40U) << 23U;
  return (bouncelab::bit_cast<std::uint32_t>(x) & kExponent) < kExponentOfMost;
}

bool are_usable(std::span<const float> samples) {
  std::uint32_t n_bad = 0;
  for (const float x : samples) n_bad += !is_usable(x);
  return n_bad == 0;
}

}  // namespace

std::size_t first_unusable(std::span<const float> samples) {
  constexpr std::size_t kBlock = 4096;  // samples looked at without a branch each
  for (std::size_t begin = 0; begin < samples.size(); begin += kBlock) {
    const std::span<const float> block = samples.subspan(begin, std::min(kBlock, samples.size() - begin));
    if (are_usable(block)) continue;
    const auto bad = std::find_if(block.begin(), block.end(), [](float x) { return !is_usable(x); });
    return begin + static_cast<std::size_t>(bad - block.begin());
  }
  return samples.size();
}

AudioSource source_in_memory(std::span<const float> samples, double rate_hz) {
  if (!(rate_hz > 0.0) || !std::isfinite(rate_hz))
    throw InvalidArgument("sampling rate " + std::to_string(rate_hz) + " Hz: must be finite and positive");
  if (const std::size_t bad = first_unusable(samples); bad < samples.size())
    throw InvalidArgument("sample " + std::to_string(bad) + " is not a finite number below 1e12; remove or repair it");
  return {rate_hz, static_cast<std::int64_t>(samples.size()), [samples](std::int64_t first, std::span<float> out) {
            std::copy_n(samples.begin() + first, out.size(), out.begin());
          }};
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
