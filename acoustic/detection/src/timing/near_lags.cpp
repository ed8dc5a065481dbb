// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/near_lags.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kStep = 4;                    // every fourth bin is kept
constexpr std::size_t kHalfWidth = 12;              // bins of the weights' one half, where they are 0
constexpr std::size_t kReach = kHalfWidth / kStep;  // bins of a part that the weights reach on either side

/// I_0 by its power series, whose terms are all positive.
double bessel_i0(double x) {
  double term = 1.0, sum = 1.0;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    term *= square(0.5 * x / k);
    sum += term;
  }
  return sum;
}

/// phi(k), k = 0 ... kHalfWidth - 1, over phi(0).
using Weights = std::array<float, kHalfWidth>;
const Weights& weights() {
  static const Weights found = [] {
    constexpr double kWidth = 2.0 * kHalfWidth / kStep;  // in bins that are kept
    const double beta = kPi * std::sqrt(square(0.75 * kWidth) - 0.8);
    Weights w;
    for (std::size_t k = 0; k < kHalfWidth; ++k) {
      const double x = static_cast<double>(k) / static_cast<double>(kHalfWidth);
      w[k] = static_cast<float>(bessel_i0(beta * std::sqrt(1.0 - x * x)) / bessel_i0(beta));
    }
    return w;
  }();
  return found;
}

/// Of 4 x 8 values in turn every fourth one, to parts[r] + k.
[[gnu::always_inline]] inline void part(const Lanes x[kStep], float* const parts[kStep], std::size_t k) {
  Lanes low[2], high[2];  // of values 4 K + 0, 1 and 4 K + 2, 3
  for (std::size_t j = 0; j < 2; ++j) {
    low[j] = __builtin_shufflevector(x[2 * j], x[2 * j + 1], 0, 4, 8, 12, 1, 5, 9, 13);
    high[j] = __builtin_shufflevector(x[2 * j], x[2 * j + 1], 2, 6, 10, 14, 3, 7, 11, 15);
  }
  const Lanes found[kStep] = {__builtin_shufflevector(low[0], low[1], 0, 1, 2, 3, 8, 9, 10, 11),
                              __builtin_shufflevector(low[0], low[1], 4, 5, 6, 7, 12, 13, 14, 15),
                              __builtin_shufflevector(high[0], high[1], 0, 1, 2, 3, 8, 9, 10, 11),
                              __builtin_shufflevector(high[0], high[1], 4, 5, 6, 7, 12, 13, 14, 15)};
  for (std::size_t r = 0; r < kStep; ++r) store(found[r], parts[r] + k);
}

/// conj(a) b, of which bin 4 K + r goes to parts[r][K].
/// @param n  bins, a multiple of 32
BOUNCELAB_VECTOR_CLONES void multiply_into_parts(const float* ar, const float* ai, const float* br, const float* bi,
                                                 float* const re[kStep], float* const im[kStep], std::size_t n) {
  for (std::size_t k = 0; k < n; k += kStep * kLanes) {
    Lanes product_re[kStep], product_im[kStep];
    for (std::size_t j = 0; j < kStep; ++j) {
      Lanes x, y, u, v;
      load(ar + k + j * kLanes, x);
      load(ai + k + j * kLanes, y);
      load(br + k + j * kLanes, u);
      load(bi + k + j * kLanes, v);
      product_re[j] = x * u + y * v;
      product_im[j] = x * v - y * u;
    }
    part(product_re, re, k / kStep);
    part(product_im, im, k / kStep);
  }
}

/// sum_x phi(x) X[4 K + x], the weights of x and -x being the same.
BOUNCELAB_VECTOR_CLONES void weigh(const float* const parts[kStep], const float* w, float* __restrict out,
                                   std::size_t n) {
  const float *a = parts[0], *b = parts[1], *c = parts[2], *d = parts[3];
  for (std::size_t k = 0; k < n; ++k) {
    const float* const x_0 = a + k;  // bins 4 (K + j)
    const float* const x_1 = b + k;  // 4 (K + j) + 1 ...
    const float* const x_2 = c + k;
    const float* const x_3 = d + k;
    const float even = (w[0] * x_0[0] + w[4] * (x_0[1] + x_0[-1])) + w[8] * (x_0[2] + x_0[-2]);
    const float half = (w[2] * (x_2[0] + x_2[-1]) + w[6] * (x_2[1] + x_2[-2])) + w[10] * (x_2[2] + x_2[-3]);
    const float near = (w[1] * (x_1[0] + x_3[-1]) + w[5] * (x_1[1] + x_3[-2])) + w[9] * (x_1[2] + x_3[-3]);
    const float far = (w[3] * (x_3[0] + x_1[-1]) + w[7] * (x_3[1] + x_1[-2])) + w[11] * (x_3[2] + x_1[-3]);
    out[k] = (even + half) + (near + far);
  }
}

/// to = (x + constant) factors
BOUNCELAB_VECTOR_CLONES void add_and_multiply(const float* x, float constant, const float* factors,
                                              float* __restrict to, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) to[k] = (x[k] + constant) * factors[k];
}

/// Memory for the parts of a spectrum and for the kept bins, of each thread: it would be set to zero at each use.
struct Workspace {
  std::vector<float> memory;
  std::array<float*, kStep> re{}, im{};  // of bin 0; there are bins before it
  float *kept_re = nullptr, *kept_im = nullptr;

  /// @param n_part  bins of a part
  /// @param n_kept  bins of the transform
  void prepare(std::size_t n_part, std::size_t n_kept) {
    const std::size_t n_behind = 2 * kReach;  // zeros: the last kept bin reaches kReach further than the products
    const std::size_t n_padded = kReach + n_part + n_behind;
    memory.resize(std::max(memory.size(), 2 * kStep * n_padded + 2 * n_kept));
    float* at = memory.data();
    for (std::array<float*, kStep>* parts : {&re, &im})
      for (float*& part : *parts) {
        part = at + kReach;
        at += n_padded;
        std::fill(part + n_part, part + n_part + n_behind, 0.0F);
      }
    kept_re = at;
    kept_im = at + n_kept;
  }
};

/// Bins below 0 are those above, conjugated: bin 4 K + r of -K is -(4 (K - 1) + 4 - r).
void set_bins_below_zero(Workspace& work) {
  for (std::size_t r = 0; r < kStep; ++r)
    for (std::size_t k = 1; k <= kReach; ++k) {
      const std::size_t bin = kStep * k - r;  // of the one above
      const auto at = -static_cast<std::ptrdiff_t>(k);
      work.re[r][at] = work.re[bin % kStep][bin / kStep];
      work.im[r][at] = -work.im[bin % kStep][bin / kStep];
    }
}

}  // namespace

NearLags::NearLags(std::size_t n) : quarter_(n / kStep) {
  for (std::size_t m = 0; m <= n / 16; ++m) {
    double psi = weights()[0];
    for (std::size_t k = 1; k < kHalfWidth; ++k)
      psi += 2.0 * static_cast<double>(weights()[k]) *
             cos(2.0 * kPi * static_cast<double>(k) * static_cast<double>(m) / static_cast<double>(n));
    correction_.push_back(static_cast<float>(std::sqrt(static_cast<double>(kStep)) / psi));
  }
  // both sides of 0, as they are used
  std::vector<float> both(correction_.rbegin(), correction_.rend() - 1);
  both.insert(both.end(), correction_.begin(), correction_.end());
  correction_ = std::move(both);
}

const NearLags& NearLags::of_length(std::size_t n) {
  static std::mutex mutex;
  static std::map<std::size_t, std::unique_ptr<const NearLags>> known;
  const std::lock_guard lock(mutex);
  std::unique_ptr<const NearLags>& here = known[n];
  if (!here) here.reset(new NearLags(n));
  return *here;
}

void NearLags::append_inverse_of_product_conj(const audio::Spectrum& a, const audio::Spectrum& b, std::size_t n_bins,
                                              std::int64_t from, std::int64_t to, std::vector<float>& out) const {
  const std::size_t n = quarter_.size();
  assert(n_bins <= n + 1 && -reach(kStep * n) <= from && from <= to && to <= reach(kStep * n));
  thread_local Workspace work;
  const std::size_t n_part = n_bins / kStep + 1, n_whole = n_bins / (kStep * kLanes) * (kStep * kLanes);
  const std::size_t n_kept = std::min(n_part + kReach, n / 2);
  work.prepare(n_part, n / 2);
  multiply_into_parts(a.re.data(), a.im.data(), b.re.data(), b.im.data(), work.re.data(), work.im.data(), n_whole);
  for (std::size_t k = n_whole; k < kStep * n_part; ++k) {
    const bool is_there = k < n_bins;
    work.re[k % kStep][k / kStep] = is_there ? a.re[k] * b.re[k] + a.im[k] * b.im[k] : 0.0F;
    work.im[k % kStep][k / kStep] = is_there ? a.re[k] * b.im[k] - a.im[k] * b.re[k] : 0.0F;
  }
  set_bins_below_zero(work);
  weigh(work.re.data(), weights().data(), work.kept_re, n_kept);
  weigh(work.im.data(), weights().data(), work.kept_im, n_kept);
  std::fill(work.kept_re + n_kept, work.kept_re + n / 2, 0.0F);
  std::fill(work.kept_im + n_kept, work.kept_im + n / 2, 0.0F);
  const std::span<const float> x = quarter_.inverse({work.kept_re, n / 2}, {work.kept_im, n / 2});
  // which has left out bin 0
  const auto constant = static_cast<float>(std::sqrt(0.5 / static_cast<double>(n))) * work.kept_re[0];
  const std::size_t begin = out.size();
  out.resize(begin + static_cast<std::size_t>(to - from + 1));
  const auto append = [&](std::int64_t first, std::int64_t last, const float* at_zero) {
    if (first > last) return;
    add_and_multiply(at_zero + first, constant, correction_.data() + (first + reach(kStep * n)),
                     out.data() + begin + static_cast<std::size_t>(first - from),
                     static_cast<std::size_t>(last - first + 1));
  };
  append(from, std::min<std::int64_t>(to, -1), x.data() + n);  // samples below 0 are at the end
  append(std::max<std::int64_t>(from, 0), to, x.data());
}

}  // namespace bouncelab::detection
