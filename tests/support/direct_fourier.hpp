// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <complex>
#include <vector>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab {

/// Discrete Fourier transform, length a power of two; Cooley and Tukey, written out so that tests need no library.
inline std::vector<std::complex<double>> fourier(const std::vector<double>& x) {
  const std::size_t n = x.size();
  std::vector<std::complex<double>> y(n);
  for (std::size_t k = 0, reversed = 0; k < n; ++k) {
    y[reversed] = x[k];
    std::size_t bit = n >> 1;
    for (; bit && (reversed & bit); bit >>= 1) reversed ^= bit;
    reversed |= bit;
  }
  for (std::size_t length = 2; length <= n; length *= 2)
    for (std::size_t j = 0; j < length / 2; ++j) {
      const auto twiddle = std::polar(1.0, -2.0 * kPi * static_cast<double>(j) / static_cast<double>(length));
      for (std::size_t start = j; start < n; start += length) {
        const auto even = y[start], odd = twiddle * y[start + length / 2];
        y[start] = even + odd;
        y[start + length / 2] = even - odd;
      }
    }
  return y;
}

}  // namespace bouncelab
