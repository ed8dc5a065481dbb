// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace bouncelab::audio {

/// One channel of sound that can be read anywhere, from a file or from memory: what lets hours pass through bounded
/// memory, several times where needed.
struct AudioSource {
  double rate_hz = 0.0;
  std::int64_t n_samples = 0;
  /// Fills `out` with the samples first ... first + out.size() - 1, all inside [0, n_samples). Full scale = 1.
  std::function<void(std::int64_t first, std::span<float> out)> read;
  /// What of it lies in memory one after the other, from sample resident_first on: need not be copied to be looked at.
  std::span<const float> resident;
  std::int64_t resident_first = 0;
};

/// AudioSource over samples that the caller keeps alive. @throws InvalidArgument naming a sample that is not finite
AudioSource source_in_memory(std::span<const float> samples, double rate_hz);

/// n samples from `first` on where they lie in memory; empty where not all do.
std::span<const float> resident_span(const AudioSource& source, std::int64_t first, std::size_t n);

/// Reads a stretch that may reach over either end; what lies outside is 0.
void read_padded(const AudioSource& source, std::int64_t first, std::span<float> out);

}  // namespace bouncelab::audio
