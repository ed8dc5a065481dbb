// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace bouncelab::audio {

/// Little-endian integers of 16 or 24 bits to floats, full scale 1, bit for bit as sf_readf_float gives them, but many
/// at a time: sf_read_raw and this take half the time of sf_readf_float (tests/bench/kernels_bench.cpp).
/// @param n_bytes  of an integer, 2 or 3
/// @param from     n integers, not aligned
void decode_pcm(const unsigned char* from, int n_bytes, float* to, std::int64_t n);

}  // namespace bouncelab::audio
