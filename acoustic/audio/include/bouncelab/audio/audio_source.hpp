// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>

namespace bouncelab::audio {

/// One channel of sound with random access, from a file or from memory, so that hours of sound can be read several
/// times in bounded memory.
struct AudioSource {
  double rate_hz = 0.0;
  std::int64_t n_samples = 0;
  /// Fills `out` with the samples first ... first + out.size() - 1, all inside [0, n_samples). Full scale = 1.
  std::function<void(std::int64_t first, std::span<float> out)> read;
};

/// Source of samples in memory, which must outlive it. @throws InvalidArgument naming a sample that is not finite
AudioSource source_in_memory(std::span<const float> samples, double rate_hz);

/// The same, to be read by several threads.
/// @param reading  held while `source` is read; one for all sources of a file
AudioSource one_at_a_time(AudioSource source, std::shared_ptr<std::mutex> reading);

/// Reads samples first ... first + out.size() - 1; those outside the recording are 0.
void read_padded(const AudioSource& source, std::int64_t first, std::span<float> out);

}  // namespace bouncelab::audio
