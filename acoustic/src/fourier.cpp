// SPDX-License-Identifier: GPL-3.0-or-later
#include "fourier.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <mutex>

#include "products.hpp"
#include "vector_clones.hpp"

namespace bouncelab {
namespace {

struct Plans {
  fftwf_plan forward = nullptr;
  fftwf_plan inverse = nullptr;
};

/// FFTW plans one at a time and only by estimate, since what it measures differs from run to run.
Plans plans_for(std::size_t n, float* samples, fftwf_complex* bins) {
  static std::mutex mutex;
  static std::map<std::size_t, Plans> known;
  const std::lock_guard lock(mutex);
  Plans& plans = known[n];
  if (plans.forward == nullptr) {
    plans.forward = fftwf_plan_dft_r2c_1d(static_cast<int>(n), samples, bins, FFTW_ESTIMATE);
    plans.inverse = fftwf_plan_dft_c2r_1d(static_cast<int>(n), bins, samples, FFTW_ESTIMATE);
  }
  return plans;
}

BOUNCELAB_VECTOR_CLONES void multiply(const float* ar, const float* ai, float sign, const float* br, const float* bi,
                                      float* re, float* im, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) {
    const float a_im = sign * ai[k];
    re[k] = ar[k] * br[k] - a_im * bi[k];
    im[k] = ar[k] * bi[k] + a_im * br[k];
  }
}

BOUNCELAB_VECTOR_CLONES void add(float* a, const float* b, float factor, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) a[k] += factor * b[k];
}

Spectrum multiplied(const Spectrum& a, float sign, const Spectrum& b) {
  const std::size_t n = std::min(a.size(), b.size());
  Spectrum out{std::vector<float>(n), std::vector<float>(n)};
  multiply(a.re.data(), a.im.data(), sign, b.re.data(), b.im.data(), out.re.data(), out.im.data(), n);
  return out;
}

}  // namespace

void Fourier::Free::operator()(void* p) const { fftwf_free(p); }

Fourier::Fourier(std::size_t n)
    : n_(n), samples_(fftwf_malloc(n * sizeof(float))), bins_(fftwf_malloc((n / 2 + 1) * sizeof(fftwf_complex))) {
  assert(n >= 4 && n % 2 == 0);
  const Plans plans = plans_for(n, static_cast<float*>(samples_.get()), static_cast<fftwf_complex*>(bins_.get()));
  forward_ = plans.forward;
  inverse_ = plans.inverse;
}

Spectrum Fourier::forward(std::span<const float> x) {
  assert(x.size() <= n_);
  auto* samples = static_cast<float*>(samples_.get());
  auto* bins = static_cast<fftwf_complex*>(bins_.get());
  std::fill(std::copy(x.begin(), x.end(), samples), samples + n_, 0.0F);
  fftwf_execute_dft_r2c(static_cast<fftwf_plan>(forward_), samples, bins);
  Spectrum out{std::vector<float>(n_ / 2 + 1, 0.0F), std::vector<float>(n_ / 2 + 1, 0.0F)};
  const auto scale = static_cast<float>(std::sqrt(2.0 / static_cast<double>(n_)));
  for (std::size_t k = 1; k < n_ / 2; ++k) {
    out.re[k] = scale * bins[k][0];
    out.im[k] = scale * bins[k][1];
  }
  return out;
}

std::vector<float> Fourier::inverse(const Spectrum& spectrum) {
  auto* samples = static_cast<float*>(samples_.get());
  auto* bins = static_cast<fftwf_complex*>(bins_.get());
  const auto scale = static_cast<float>(1.0 / std::sqrt(2.0 * static_cast<double>(n_)));
  for (std::size_t k = 0; k <= n_ / 2; ++k) {
    const bool known = k < spectrum.size() && k > 0 && k < n_ / 2;
    bins[k][0] = known ? scale * spectrum.re[k] : 0.0F;
    bins[k][1] = known ? scale * spectrum.im[k] : 0.0F;
  }
  fftwf_execute_dft_c2r(static_cast<fftwf_plan>(inverse_), bins, samples);
  return {samples, samples + n_};
}

std::size_t power_of_two(std::size_t n) {
  std::size_t power = 4;
  while (power < n) power *= 2;
  return power;
}

Spectrum phasors(std::size_t n, double angle) {
  constexpr std::size_t kBlock = 32;
  std::vector<float> step_re(kBlock), step_im(kBlock);
  for (std::size_t j = 0; j < kBlock; ++j) {
    step_re[j] = static_cast<float>(std::cos(angle * static_cast<double>(j)));
    step_im[j] = static_cast<float>(std::sin(angle * static_cast<double>(j)));
  }
  Spectrum out{std::vector<float>(n), std::vector<float>(n)};
  for (std::size_t k = 0; k < n; k += kBlock) {
    const auto c = static_cast<float>(std::cos(angle * static_cast<double>(k)));
    const auto s = static_cast<float>(std::sin(angle * static_cast<double>(k)));
    const std::size_t n_here = std::min(kBlock, n - k);
    for (std::size_t j = 0; j < n_here; ++j) {
      out.re[k + j] = c * step_re[j] - s * step_im[j];
      out.im[k + j] = c * step_im[j] + s * step_re[j];
    }
  }
  return out;
}

Spectrum product_conj(const Spectrum& a, const Spectrum& b) { return multiplied(a, -1.0F, b); }
Spectrum product(const Spectrum& a, const Spectrum& b) { return multiplied(a, 1.0F, b); }

void add_scaled(Spectrum& a, const Spectrum& b, double factor) {
  const auto f = static_cast<float>(factor);
  add(a.re.data(), b.re.data(), f, std::min(a.size(), b.size()));
  add(a.im.data(), b.im.data(), f, std::min(a.size(), b.size()));
}

double energy(const Spectrum& a) { return dot(a.re, a.re) + dot(a.im, a.im); }

}  // namespace bouncelab
