// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>

namespace bouncelab::audio {

struct FreeSamples {
  void operator()(float* samples) const { std::free(samples); }
};
using SampleMemory = std::unique_ptr<float[], FreeSamples>;

/// Memory for n samples, not set to anything. From 1 MB on in pages of 2 MB where the system has them for those who
/// ask: the first write to a page of 4 kB takes longer than decoding the thousand samples that it holds.
/// @throws std::bad_alloc
SampleMemory sample_memory(std::size_t n);

}  // namespace bouncelab::audio
