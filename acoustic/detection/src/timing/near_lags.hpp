// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {

/// The inverse Fourier transform of length N of a real signal x near sample 0, by a transform of a quarter of the
/// length: a spectrum of which every fourth bin is kept is that of the signal with itself N/4, N/2 ... later added;
/// weighing neighbouring bins first multiplies the signal by a window that is small there.
///
///   Q[K] = sum_k phi(k - 4 K) X[k],   x[m] = 2 / psi[m] q[m],   psi[m] = sum_k phi(k) cos(2 pi k m / N)
///
/// for |m| <= N / 16, with phi(k) = I_0(beta sqrt(1 - (k / 12)^2)) and beta = pi sqrt((3/4 6)^2 - 0.8): within 1.5e-5
/// of the largest magnitude of x; single precision adds 1e-6. The factor 2 is that of the scale of RealFft. Sources:
/// Dutt & Rokhlin, SIAM J. Sci. Comput. 14, 1368 (1993), doi:10.1137/0914081; beta: Beatty, Nishimura & Pauly, IEEE
/// Trans. Med. Imaging 24, 799 (2005), doi:10.1109/TMI.2005.848376.
class NearLags {
 public:
  static constexpr std::size_t kShortest = 64;
  /// That of one length, made once and kept.
  /// @param n  N, a power of two, at least kShortest
  static const NearLags& of_length(std::size_t n);

  /// Largest |m| that inverse_of_product_conj() gives.
  static std::int64_t reach(std::size_t n) { return static_cast<std::int64_t>(n / 16); }

  /// Appends RealFft(n).inverse(product_conj(a, b)) at samples from ... to, -reach <= from <= to <= reach.
  /// @param n_bins  bins that hold products; at most N / 4 + 1: at a step of half a sample there are no others
  void append_inverse_of_product_conj(const audio::Spectrum& a, const audio::Spectrum& b, std::size_t n_bins,
                                      std::int64_t from, std::int64_t to, std::vector<float>& out) const;

 private:
  explicit NearLags(std::size_t n);

  audio::RealFft quarter_;
  std::vector<float> correction_;  // 2 / psi
};

}  // namespace bouncelab::detection
