// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

namespace bouncelab::audio {

/// Sum of products over the shorter of both; partial sums in single precision, side by side.
double dot(std::span<const float> a, std::span<const float> b);

/// Sum of a few hundred values, in single precision, side by side.
double sum(std::span<const float> x);

/// sum_k (first + k) x[k], likewise.
double moment(std::span<const float> x, std::size_t first);

/// out[n] = sum_k taps[k] x[n + k]; every sum in the same order, wherever it stands in `out`.
/// @param x  at least out.size() + taps.size() - 1 samples
void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out);

}  // namespace bouncelab::audio
