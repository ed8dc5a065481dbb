// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

namespace bouncelab {

/// Sum of products over the shorter of both; partial sums in single precision, side by side.
double dot(std::span<const float> a, std::span<const float> b);

/// out[n] = sum_k taps[k] x[n + k]; every sum in the same order, wherever it stands in `out`.
/// @param x  at least out.size() + taps.size() - 1 samples
void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out);

}  // namespace bouncelab
