// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/real_fft.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::audio {
namespace {

struct Phasor {
  double c = 1.0;
  double s = 0.0;
};

Phasor times(Phasor a, Phasor b) { return {a.c * b.c - a.s * b.s, a.c * b.s + a.s * b.c}; }

/// exp(i j angle) for one block of j, and for the block's length: one sine and cosine in all.
struct PhaseSteps {
  static constexpr std::size_t kBlock = 32;
  std::array<float, kBlock> c, s;
  Phasor block;

  explicit PhaseSteps(double angle) {
    std::array<Phasor, kBlock + 1> p;
    p[1] = {cos(angle), sin(angle)};
    for (std::size_t j = 2; j <= kBlock; ++j) p[j] = times(p[j / 2], p[j - j / 2]);  // errors grow with log j
    for (std::size_t j = 0; j < kBlock; ++j) {
      c[j] = static_cast<float>(p[j].c);
      s[j] = static_cast<float>(p[j].s);
    }
    block = p[kBlock];
  }
};

/// x(k) exp(i k angle), block by block.
/// @param value  of bin k, into a real and an imaginary part
template <class Value>
[[gnu::always_inline]] inline void times_phasors(const Value& value, const PhaseSteps& steps, float* __restrict re,
                                                 float* __restrict im, std::size_t n) {
  double block_c = 1.0;  // n / 32 roundings of doubles: nothing to a float
  double block_s = 0.0;
  for (std::size_t k = 0; k < n; k += PhaseSteps::kBlock) {
    const auto c = static_cast<float>(block_c);
    const auto s = static_cast<float>(block_s);
    const std::size_t n_here = std::min(PhaseSteps::kBlock, n - k);
    for (std::size_t j = 0; j < n_here; ++j) {
      const float here_c = c * steps.c[j] - s * steps.s[j];
      const float here_s = c * steps.s[j] + s * steps.c[j];
      float x, y;
      value(k + j, x, y);
      re[k + j] = x * here_c - y * here_s;
      im[k + j] = x * here_s + y * here_c;
    }
    const double next_c = block_c * steps.block.c - block_s * steps.block.s;
    block_s = block_c * steps.block.s + block_s * steps.block.c;
    block_c = next_c;
  }
}

void shift(const float* a_re, const float* a_im, const PhaseSteps& steps, float* __restrict re, float* __restrict im,
           std::size_t n) {
  times_phasors(
      [&](std::size_t k, float& x, float& y) {
        x = a_re[k];
        y = a_im[k];
      },
      steps, re, im, n);
}

void multiply_conj(const float* ar, const float* ai, const float* br, const float* bi, const PhaseSteps& steps,
                   float* __restrict re, float* __restrict im, std::size_t n) {
  times_phasors(
      [&](std::size_t k, float& x, float& y) {
        x = ar[k] * br[k] + ai[k] * bi[k];
        y = ar[k] * bi[k] - ai[k] * br[k];
      },
      steps, re, im, n);
}

Spectrum of_size(std::size_t n) { return {std::vector<float>(n), std::vector<float>(n)}; }

}  // namespace

Spectrum phase_shifted(const Spectrum& a, double angle) {
  Spectrum out = of_size(a.size());
  shift(a.re.data(), a.im.data(), PhaseSteps(angle), out.re.data(), out.im.data(), a.size());
  return out;
}

Spectrum product_conj(const Spectrum& a, const Spectrum& b, std::size_t n, double angle) {
  Spectrum out = of_size(n);
  multiply_conj(a.re.data(), a.im.data(), b.re.data(), b.im.data(), PhaseSteps(angle), out.re.data(), out.im.data(), n);
  return out;
}

Spectrum product_conj(const Spectrum& a, const Spectrum& b) {
  Spectrum out = of_size(std::min(a.size(), b.size()));
  for (std::size_t k = 0; k < out.size(); ++k) {
    out.re[k] = a.re[k] * b.re[k] + a.im[k] * b.im[k];
    out.im[k] = a.re[k] * b.im[k] - a.im[k] * b.re[k];
  }
  return out;
}

void add_scaled(Spectrum& a, const Spectrum& b, double factor) {
  const auto f = static_cast<float>(factor);
  const std::size_t n = std::min(a.size(), b.size());
  add_scaled(a.re.data(), f, b.re.data(), n);
  add_scaled(a.im.data(), f, b.im.data(), n);
}

double energy(const Spectrum& a) { return dot(a.re, a.re) + dot(a.im, a.im); }

}  // namespace bouncelab::audio
