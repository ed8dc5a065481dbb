// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::synthesis {

/// Free ringing of many resonators by one inverse Fourier transform, a non-uniform one of the first type:
///
///   Re sum_p z_p exp(s_p n) = 1 / psi(n) Re sum_k exp(2 pi i k n / M) sum_p z_p phi(k - nu_p),   nu_p = s_p M / (2 pi
///   i) phi(x) = I_0(beta sqrt(1 - (2 x / w)^2)),   psi its transform
///
/// for |n| <= M / 4, with w = 12 bins and beta = 3/4 pi w: within 3e-8 of |z_p|, where s_p decays by at most exp(-4) in
/// M / 2 frames; single precision adds 2e-7. Sources: Dutt & Rokhlin, SIAM J. Sci. Comput. 14, 1368 (1993),
/// doi:10.1137/0914081; Fessler & Sutton, IEEE Trans. Signal Process. 51, 560 (2003), doi:10.1109/TSP.2002.807005.
class RingingTransform {
 public:
  /// The frames that one transform gives: half of its length M.
  static constexpr std::size_t kFrames = 512;

  /// @param poles  s_p per frame
  explicit RingingTransform(const std::vector<std::complex<double>>& poles);

  /// Whether this pole is neither so strongly damped nor so close to 0 or half the rate that it has to be summed
  /// otherwise.
  bool holds(std::size_t pole) const { return holds_[pole]; }
  /// Adds Re sum_p z_p exp(s_p j), j = 0 ... kFrames - 1, over the poles that it holds.
  /// @param re, im  z_p by pole; 0 of those that are silent
  void add(const float* re, const float* im, std::span<float> out) const;

 private:
  audio::RealFft fft_;
  std::vector<bool> holds_;
  // of each row, such that neighbours do not share bins: each would wait for the one before
  std::vector<std::size_t> poles_, first_bins_;
  std::vector<float> re_, im_;     // 16 for each row: phi, moved from the middle to the first frame
  std::vector<float> correction_;  // kFrames: 1 / psi
};

}  // namespace bouncelab::synthesis
