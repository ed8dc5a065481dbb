// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/product_moments.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kMostOfSeries = 0.25;  // of omega h |d|
constexpr double kMostOfPhase = 1.0;    // of omega k |d|, for which phasor() is made

/// exp(i x) for |x| <= 1, to 3e-8: without branches, so that all sub-bands go side by side.
[[gnu::always_inline]] inline void phasor(double x, double& c, double& s) {
  const double y = x * x;
  c = 1.0 - y * 0.5 * (1.0 - y * (1.0 / 12) * (1.0 - y * (1.0 / 30) * (1.0 - y * (1.0 / 56) * (1.0 - y * (1.0 / 90)))));
  s = x * (1.0 - y * (1.0 / 6) * (1.0 - y * (1.0 / 20) * (1.0 - y * (1.0 / 42) * (1.0 - y * (1.0 / 72)))));
}

/// Sums of x u^m, m = 0 ... n_moments - 1, of real and imaginary parts, where u grows evenly from bin to bin and is 0
/// in the middle; by lane.
/// @param sums  n_moments for the real parts, then for the imaginary ones
template <std::size_t n_moments>
[[gnu::always_inline]] inline void add_moments(const float* re, const float* im, std::size_t n, float per_bin,
                                               Lanes* sums) {
  Lanes of_re[n_moments] = {}, of_im[n_moments] = {};
  Lanes number = Lanes{0, 1, 2, 3, 4, 5, 6, 7} - 0.5F * static_cast<float>(n - 1);
  const auto add = [&](Lanes& x, Lanes& y) {  // which it multiplies
    const Lanes u = per_bin * number;
#pragma GCC unroll 8
    for (std::size_t m = 0; m < n_moments; ++m) {
      of_re[m] += x;
      of_im[m] += y;
      x *= u;
      y *= u;
    }
    number += static_cast<float>(kLanes);
  };
  std::size_t k = 0;
  for (; k + kLanes <= n; k += kLanes) {
    Lanes x, y;
    load(re + k, x);
    load(im + k, y);
    add(x, y);
  }
  if (k < n) {
    Lanes x{}, y{};
    for (std::size_t lane = 0; k + lane < n; ++lane) {
      x[lane] = re[k + lane];
      y[lane] = im[k + lane];
    }
    add(x, y);
  }
  std::memcpy(sums, of_re, sizeof of_re);
  std::memcpy(sums + n_moments, of_im, sizeof of_im);
}

/// Eight sums of eight lanes each.
[[gnu::always_inline]] inline void sum_lanes(const Lanes* x, float* sums) {
  Lanes fours[4];
  for (std::size_t k = 0; k < 4; ++k)
    fours[k] = __builtin_shufflevector(x[k], x[k + 4], 0, 1, 2, 3, 8, 9, 10, 11) +
               __builtin_shufflevector(x[k], x[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  Lanes twos[2];
  for (std::size_t k = 0; k < 2; ++k)
    twos[k] = __builtin_shufflevector(fours[k], fours[k + 2], 0, 1, 8, 9, 4, 5, 12, 13) +
              __builtin_shufflevector(fours[k], fours[k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
  // of vectors 0 1, 2 3, 4 5, 6 7, in turn
  const Lanes all = __builtin_shufflevector(twos[0], twos[1], 0, 8, 2, 10, 4, 12, 6, 14) +
                    __builtin_shufflevector(twos[0], twos[1], 1, 9, 3, 11, 5, 13, 7, 15);
  store(all, sums);
}

constexpr std::size_t kMoments = 6;
using OfSubbands = std::array<double, kMaxSubbands>;
constexpr std::size_t kSums = 2 * kMoments;  // of a sub-band
constexpr std::size_t kAllSums = kSums * kMaxSubbands;
static_assert(kAllSums % kLanes == 0);

struct BinRange {
  std::size_t from = 0, size = 0;
};

/// @param sums  kSums for each sub-band
BOUNCELAB_VECTOR_CLONES void moments_of(const float* re, const float* im, const BinRange* bands, std::size_t n_bands,
                                        float* sums) {
  Lanes by_lane[kAllSums];
  for (std::size_t j = 0; j < n_bands; ++j)
    add_moments<kMoments>(re + bands[j].from, im + bands[j].from, bands[j].size,
                          2.0F / static_cast<float>(bands[j].size), by_lane + j * kSums);
  for (std::size_t k = n_bands * kSums; k < kAllSums; ++k) by_lane[k] = Lanes{};
  for (std::size_t k = 0; k < kAllSums; k += kLanes) sum_lanes(by_lane + k, sums + k);
}

/// z = e^(i centre d) Z(d) and its derivative by d, real parts.
/// @param re, im  coefficients of Z, of each power for all sub-bands
BOUNCELAB_VECTOR_CLONES void evaluate(const OfSubbands* re, const OfSubbands* im, const double* centre, double d,
                                      double* __restrict in_phase, double* __restrict quadrature) {
  for (std::size_t j = 0; j < kMaxSubbands; ++j) {
    double z_re = re[kMoments - 1][j], z_im = im[kMoments - 1][j];
    double slope_re = 0.0, slope_im = 0.0;
#pragma GCC unroll 8
    for (std::size_t m = kMoments - 1; m-- > 0;) {
      slope_re = slope_re * d + z_re;
      slope_im = slope_im * d + z_im;
      z_re = z_re * d + re[m][j];
      z_im = z_im * d + im[m][j];
    }
    double c, s;
    phasor(centre[j] * d, c, s);
    in_phase[j] = c * z_re - s * z_im;
    const double turned_re = slope_re - centre[j] * z_im, turned_im = slope_im + centre[j] * z_re;
    quadrature[j] = c * turned_re - s * turned_im;
  }
}

}  // namespace

ProductMoments::ProductMoments(const MatchedFilter& filter, const Subbands& subbands, const audio::Spectrum& sound)
    : filter_(filter),
      subbands_(subbands),
      sound_(sound),
      n_(std::min(filter.n_filled(), sound.size())),
      products_(std::make_unique_for_overwrite<float[]>(2 * n_)) {}

void ProductMoments::expand_at(double shift) {
  static_assert(kMoments == kOrder + 1);
  float* const re = products_.get();
  float* const im = re + n_;
  audio::product_conj(filter_.spectrum(), sound_, n_, filter_.omega() * shift, re, im);
  std::array<BinRange, kMaxSubbands> bands{};
  std::size_t widest = 1;
  for (std::size_t j = 0; j < subbands_.n(); ++j) {
    const std::size_t from = std::min(subbands_.edge[j], n_);
    bands[j] = {from, std::min(subbands_.edge[j + 1], n_) - from};
    widest = std::max(widest, bands[j].size);
  }
  std::array<float, kAllSums> sums;
  moments_of(re, im, bands.data(), subbands_.n(), sums.data());
  for (std::size_t j = 0; j < subbands_.n(); ++j) {
    centre_[j] =
        filter_.omega() * (static_cast<double>(bands[j].from) + 0.5 * (static_cast<double>(bands[j].size) - 1.0));
    const double half = filter_.omega() * 0.5 * static_cast<double>(bands[j].size);
    double factor = 1.0;  // (omega h)^m / m!, to which i^m comes
    for (std::size_t m = 0; m <= kOrder; ++m) {
      const double x = factor * static_cast<double>(sums[j * kSums + m]);
      const double y = factor * static_cast<double>(sums[j * kSums + kMoments + m]);
      const bool is_odd = m % 2 != 0;
      const double sign = m % 4 >= 2 ? -1.0 : 1.0;
      re_[m][j] = sign * (is_odd ? -y : x);
      im_[m][j] = sign * (is_odd ? x : y);
      factor *= half / static_cast<double>(m + 1);
    }
  }
  around_ = shift;
  farthest_ =
      std::min(kMostOfSeries / (0.5 * static_cast<double>(widest)), kMostOfPhase / static_cast<double>(n_ + 1)) /
      filter_.omega();
}

SubbandSums ProductMoments::sums_at(double shift) {
  if (std::abs(shift - around_) > farthest_) expand_at(shift);
  SubbandSums sums;
  evaluate(re_.data(), im_.data(), centre_.data(), shift - around_, sums.in_phase.data(), sums.quadrature.data());
  return sums;
}

}  // namespace bouncelab::detection
