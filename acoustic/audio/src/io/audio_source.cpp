// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/sound_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

constexpr double kLeastZeros_s = 1.0;

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

AudioSource source_in_memory(std::span<const float> samples, double rate_hz, int n_channels, int channel) {
  if (!(rate_hz > 0.0) || !std::isfinite(rate_hz))
    throw InvalidArgument("sampling rate " + std::to_string(rate_hz) + " Hz: must be finite and positive");
  const auto step = static_cast<std::size_t>(n_channels), at = static_cast<std::size_t>(channel);
  if (const std::size_t bad = first_unusable(samples); bad < samples.size())
    throw InvalidArgument("sample " + std::to_string(bad / step) +
                          (n_channels > 1 ? " of channel " + std::to_string(bad % step) : "") +
                          " is not a finite number below 1e12; remove or repair it");
  return {rate_hz, static_cast<std::int64_t>(samples.size() / step),
          [samples, step, at](std::int64_t first, std::span<float> out) {
            const std::span<const float> from = samples.subspan(static_cast<std::size_t>(first) * step + at);
            if (step == 1) return void(std::copy_n(from.begin(), out.size(), out.begin()));
            for (std::size_t k = 0; k < out.size(); ++k) out[k] = from[k * step];
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

PartOfSource without_zeros_around(const AudioSource& source) {
  constexpr std::int64_t kAtOnce = 1 << 13;
  const auto is_sound = [](float x) { return std::abs(x) >= kLeastSound; };
  std::vector<float> x;
  std::int64_t begin = 0, end = source.n_samples;
  const auto read = [&](bool from_end) {
    x.resize(static_cast<std::size_t>(std::min(kAtOnce, end - begin)));
    source.read(from_end ? end - std::ssize(x) : begin, x);
  };
  for (std::int64_t n_zeros = 0; begin < end && n_zeros == std::ssize(x); begin += n_zeros) {
    read(false);
    n_zeros = std::find_if(x.begin(), x.end(), is_sound) - x.begin();
  }
  if (begin == end) return {source};
  const auto n_least = static_cast<std::int64_t>(kLeastZeros_s * source.rate_hz);
  if (begin < n_least) begin = 0;
  x.clear();
  for (std::int64_t n_zeros = 0; n_zeros == std::ssize(x); end -= n_zeros) {
    read(true);
    n_zeros = std::find_if(x.rbegin(), x.rend(), is_sound) - x.rbegin();
  }
  if (source.n_samples - end < n_least) end = source.n_samples;
  PartOfSource part{source, static_cast<double>(begin) / source.rate_hz};
  part.sound.n_samples = end - begin;
  part.sound.read = [read_all = source.read, begin](std::int64_t first, std::span<float> out) {
    read_all(begin + first, out);
  };
  for (Silence& silence : part.sound.silences) silence = {silence.begin_s - part.begin_s, silence.end_s - part.begin_s};
  return part;
}

}  // namespace bouncelab::audio
