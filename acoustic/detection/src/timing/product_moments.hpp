// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "bouncelab/audio/dsp/real_fft.hpp"
#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// In-phase and quadrature sums of each sub-band at a shift s, with the products P = conj(W) Y of a template and a
/// sound:
///
///   z_j(s) = sum_k P_k e^(i omega k s),   in_phase = Re z_j,   quadrature = Re dz_j / ds
struct SubbandSums {
  std::array<double, kMaxSubbands> in_phase{};
  std::array<double, kMaxSubbands> quadrature{};
};

/// The sums of a template and a sound at shifts close to each other, by one pass over the bins: with c the middle of a
/// sub-band, h half of its width, s = s_0 + d and the moments M_m = sum_k P_k e^(i omega k s_0) ((k - c) / h)^m,
///
///   z_j = e^(i omega c d) sum_m M_m (i omega h d)^m / m!
///
/// up to m = 5 while omega h |d| <= 1/4: within 4e-7 of sum |P_k|, the derivative within 4e-5 omega h of it. Further
/// off the moments are taken anew.
class ProductMoments {
 public:
  /// @param filter, subbands, sound  kept by reference
  ProductMoments(const MatchedFilter& filter, const Subbands& subbands, const audio::Spectrum& sound);

  SubbandSums sums_at(double shift);

 private:
  static constexpr std::size_t kOrder = 5;
  using Coefficients = std::array<std::array<double, kMaxSubbands>, kOrder + 1>;

  void expand_at(double shift);
  SubbandSums sums_of_series(double shift) const;

  const MatchedFilter& filter_;
  const Subbands& subbands_;
  const audio::Spectrum& sound_;
  std::size_t n_;                              // bins that hold products
  std::unique_ptr<float[]> products_;          // real and imaginary parts; a vector would be set to zero first
  double around_ = 0.0;                        // the shift s_0
  double farthest_ = -1.0;                     // largest |d|; below 0 before the first expansion
  std::array<double, kMaxSubbands> centre_{};  // omega c
  Coefficients re_{}, im_{};                   // of the series in d
};

}  // namespace bouncelab::detection
