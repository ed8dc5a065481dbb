// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace bouncelab::audio {

/// Samples that lie in a file one after the other, little-endian: decoded here, not by libsndfile.
enum class PlainEncoding : std::int32_t { none, int16, int24, float32, float64 };

/// 0 for none.
int bytes_per_sample(PlainEncoding encoding);

/// Integers to floats of full scale 1, bit for bit as sf_readf_float gives them, but many at a time: reading the bytes
/// and this take half the time of sf_readf_float (tests/bench/kernels_bench.cpp). Floats are copied, doubles rounded.
/// @param from  out.size() samples, not aligned
void decode_pcm(std::span<const std::byte> from, PlainEncoding encoding, std::span<float> out);

}  // namespace bouncelab::audio
