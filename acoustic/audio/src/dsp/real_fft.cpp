// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/real_fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <type_traits>

namespace bouncelab::audio {

// not in an anonymous namespace: RealFft::Plan has members of this type
struct DestroyPlan {
  void operator()(fftwf_plan plan) const { fftwf_destroy_plan(plan); }
};
using FftwPlan = std::unique_ptr<std::remove_pointer_t<fftwf_plan>, DestroyPlan>;

struct RealFft::Plan {
  FftwPlan forward, inverse;
};

namespace {

/// Buffers of transforms of up to n samples, one set for each thread.
struct Workspace {
  float* samples = nullptr;       // n
  fftwf_complex* bins = nullptr;  // n / 2 + 1
};

template <class T>
T* fftw_array(std::size_t n) {
  auto* const array = static_cast<T*>(fftwf_malloc(n * sizeof(T)));
  if (array == nullptr) throw std::bad_alloc();
  return array;
}

Workspace& workspace_for(std::size_t n) {
  struct Free {
    void operator()(void* p) const { fftwf_free(p); }
  };
  thread_local std::unique_ptr<float, Free> samples;
  thread_local std::unique_ptr<fftwf_complex, Free> bins;
  thread_local std::size_t n_held = 0;
  thread_local Workspace work;
  if (n > n_held) {
    samples.reset(fftw_array<float>(n));
    bins.reset(fftw_array<fftwf_complex>(n / 2 + 1));
    work = {samples.get(), bins.get()};
    n_held = n;
  }
  return work;
}

/// FFTW may plan on one thread at a time. By estimate only: the plans that it measures differ from run to run. Without
/// its vector instructions, which differ from processor to processor: their last digits moved impacts of a recording by
/// 5 us and its eps by 1e-3.
const RealFft::Plan& plan_for(std::size_t n) {
  constexpr unsigned kHow = FFTW_ESTIMATE | FFTW_NO_SIMD;
  static std::mutex mutex;
  static std::map<std::size_t, RealFft::Plan> known;
  const std::lock_guard lock(mutex);
  RealFft::Plan& plan = known[n];
  if (plan.forward == nullptr) {
    const Workspace& work = workspace_for(n);
    plan.forward.reset(fftwf_plan_dft_r2c_1d(static_cast<int>(n), work.samples, work.bins, kHow));
    plan.inverse.reset(fftwf_plan_dft_c2r_1d(static_cast<int>(n), work.bins, work.samples, kHow));
  }
  return plan;
}

}  // namespace

RealFft::RealFft(std::size_t n) : n_(n), plan_(&plan_for(n)) { assert(n >= 4 && n % 2 == 0); }

Spectrum RealFft::forward(std::span<const float> x) const {
  Spectrum spectrum;
  forward(x, spectrum);
  return spectrum;
}

void RealFft::forward(std::span<const float> x, Spectrum& spectrum) const {
  assert(x.size() <= n_);
  const std::size_t h = n_ / 2;
  Workspace& work = workspace_for(n_);
  std::fill(std::copy(x.begin(), x.end(), work.samples), work.samples + n_, 0.0F);
  fftwf_execute_dft_r2c(plan_->forward.get(), work.samples, work.bins);
  spectrum.re.resize(h + 1);
  spectrum.im.resize(h + 1);
  const auto scale = static_cast<float>(std::sqrt(2.0 / static_cast<double>(n_)));
  float* __restrict const re = spectrum.re.data();
  float* __restrict const im = spectrum.im.data();
  for (std::size_t k = 1; k < h; ++k) {
    re[k] = scale * work.bins[k][0];
    im[k] = scale * work.bins[k][1];
  }
  spectrum.re[0] = spectrum.im[0] = spectrum.re[h] = spectrum.im[h] = 0.0F;
}

std::vector<float> RealFft::inverse(const Spectrum& spectrum) const {
  const std::span<const float> x = inverse(spectrum.re, spectrum.im);
  return {x.begin(), x.end()};
}

std::span<const float> RealFft::inverse(std::span<const float> re, std::span<const float> im) const {
  Workspace& work = workspace_for(n_);
  const std::size_t h = n_ / 2, n_bins = std::min(re.size(), h);
  const auto scale = static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_)));
  float* __restrict const bins = &work.bins[0][0];
  std::fill_n(bins, 2 * (h + 1), 0.0F);
  for (std::size_t k = 1; k < n_bins; ++k) {
    bins[2 * k] = scale * re[k];
    bins[2 * k + 1] = scale * im[k];
  }
  fftwf_execute_dft_c2r(plan_->inverse.get(), work.bins, work.samples);
  return {work.samples, n_};
}

}  // namespace bouncelab::audio
