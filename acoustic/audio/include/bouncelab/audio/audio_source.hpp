// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace bouncelab::audio {

/// One channel of sound with random access, from a file or from memory, so that hours of sound can be read several
/// times in bounded memory.
struct AudioSource {
  double rate_hz = 0.0;
  std::int64_t n_samples = 0;
  /// Fills `out` with the samples first ... first + out.size() - 1, all inside [0, n_samples). Full scale = 1. Called
  /// from any thread.
  std::function<void(std::int64_t first, std::span<float> out)> read;
};

/// Source of samples in memory, which must outlive it. @throws InvalidArgument naming a sample that is not finite
AudioSource source_in_memory(std::span<const float> samples, double rate_hz);

/// Reads samples first ... first + out.size() - 1; those outside the recording are 0.
void read_padded(const AudioSource& source, std::int64_t first, std::span<float> out);

/// Index of the first sample that is infinite or no number, or how many samples there are.
std::size_t first_not_finite(std::span<const float> samples);

}  // namespace bouncelab::audio
