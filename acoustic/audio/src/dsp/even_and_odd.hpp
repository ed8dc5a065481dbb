// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace bouncelab::audio {

/// The transform of a real signal of length n from that of its even samples + i its odd samples, Z = E + i O of length
/// h = n / 2:
///
///   X[k] = E[k] + exp(-2 pi i k / n) O[k],   E[k] = (Z[k] + conj Z[h - k]) / 2,   O[k] = (Z[k] - conj Z[h - k]) / 2i
///
/// Bins k and h - k are of the same two numbers, and are computed together.
/// @param z             h complex numbers, real and imaginary parts in turn
/// @param cosine, sine  of 2 pi k / n, k = 0 ... h / 2
/// @param scale         of the result, times 2
/// @param re, im        receive bins 1 ... h - 1
void unpack_even_and_odd(const float* z, const float* cosine, const float* sine, float scale, float* re, float* im,
                         std::size_t h);

/// The inverse: Z from X, but for its first number.
/// @param re, im  h bins, of which the first is not read
void pack_even_and_odd(const float* re, const float* im, const float* cosine, const float* sine, float scale, float* z,
                       std::size_t h);

}  // namespace bouncelab::audio
