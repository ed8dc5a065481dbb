// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/real_fft.hpp"

#include <fftw3.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <numbers>
#include <type_traits>

#include "bouncelab/core/elementary.hpp"
#include "dsp/even_and_odd.hpp"

namespace bouncelab::audio {

// not in an anonymous namespace: RealFft::Plan has members of this type
struct DestroyPlan {
  void operator()(fftwf_plan plan) const { fftwf_destroy_plan(plan); }
};
using FftwPlan = std::unique_ptr<std::remove_pointer_t<fftwf_plan>, DestroyPlan>;

/// A real signal of length n is transformed as a complex one of length n/2: 1.5 to 2.3 times as fast, packing included,
/// as FFTW's own real transform planned by estimate (n = 1024 to 4096, tests/bench/kernels_bench.cpp).
struct RealFft::Plan {
  FftwPlan forward, inverse;
  std::vector<float> cosine, sine;  // of 2 pi k / n, k = 0 ... n/4
};

namespace {

/// Buffers of transforms of up to n samples, one set for each thread.
struct Workspace {
  float* in = nullptr;  // n
  float* out = nullptr;
  float* re = nullptr;  // n / 2
  float* im = nullptr;
};

Workspace& workspace_for(std::size_t n) {
  struct Free {
    void operator()(void* p) const { fftwf_free(p); }
  };
  thread_local std::unique_ptr<float, Free> held;
  thread_local std::size_t n_held = 0;
  thread_local Workspace work;
  if (n > n_held) {
    constexpr std::size_t kAligned = 32;  // floats
    const std::size_t n_part = (n / 2 + kAligned) / kAligned * kAligned;
    const std::size_t n_whole = (n + kAligned) / kAligned * kAligned;
    held.reset(static_cast<float*>(fftwf_malloc(2 * (n_whole + n_part) * sizeof(float))));
    if (held == nullptr) throw std::bad_alloc();
    n_held = n;
    work.in = held.get();
    work.out = work.in + n_whole;
    work.re = work.out + n_whole;
    work.im = work.re + n_part;
  }
  return work;
}

fftwf_complex* as_complex(float* x) { return reinterpret_cast<fftwf_complex*>(x); }

/// FFTW may plan on one thread at a time; by estimate only, because the plans that it measures differ from run to run.
const RealFft::Plan& plan_for(std::size_t n) {
  static std::mutex mutex;
  static std::map<std::size_t, RealFft::Plan> known;
  const std::lock_guard lock(mutex);
  RealFft::Plan& plan = known[n];
  if (plan.forward == nullptr) {
    const auto size = static_cast<int>(n / 2);
    const Workspace& work = workspace_for(n);
    plan.forward.reset(fftwf_plan_dft_1d(size, as_complex(work.in), as_complex(work.out), FFTW_FORWARD, FFTW_ESTIMATE));
    plan.inverse.reset(
        fftwf_plan_dft_1d(size, as_complex(work.in), as_complex(work.out), FFTW_BACKWARD, FFTW_ESTIMATE));
    for (int k = 0; k <= size / 2; ++k) {
      const double phase = 2.0 * std::numbers::pi * k / static_cast<double>(n);
      plan.cosine.push_back(static_cast<float>(cos(phase)));
      plan.sine.push_back(static_cast<float>(sin(phase)));
    }
  }
  return plan;
}

}  // namespace

RealFft::RealFft(std::size_t n) : n_(n), plan_(&plan_for(n)) { assert(n >= 4 && std::has_single_bit(n)); }

Spectrum RealFft::forward(std::span<const float> x) {
  Spectrum spectrum;
  forward(x, spectrum);
  return spectrum;
}

void RealFft::forward(std::span<const float> x, Spectrum& spectrum) {
  assert(x.size() <= n_);
  const std::size_t h = n_ / 2;
  const Plan& plan = *plan_;
  Workspace& work = workspace_for(n_);
  std::fill(std::copy(x.begin(), x.end(), work.in), work.in + n_, 0.0F);
  fftwf_execute_dft(plan.forward.get(), as_complex(work.in), as_complex(work.out));
  spectrum.re.resize(h + 1);
  spectrum.im.resize(h + 1);
  unpack_even_and_odd(work.out, plan.cosine.data(), plan.sine.data(),
                      static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_))), spectrum.re.data(),
                      spectrum.im.data(), h);
  spectrum.re[0] = spectrum.im[0] = spectrum.re[h] = spectrum.im[h] = 0.0F;
}

std::vector<float> RealFft::inverse(const Spectrum& spectrum) {
  const std::size_t h = n_ / 2;
  const float* re = spectrum.re.data();
  const float* im = spectrum.im.data();
  if (spectrum.size() < h) {
    Workspace& work = workspace_for(n_);
    std::fill(std::copy(spectrum.re.begin(), spectrum.re.end(), work.re), work.re + h, 0.0F);
    std::fill(std::copy(spectrum.im.begin(), spectrum.im.end(), work.im), work.im + h, 0.0F);
    re = work.re;
    im = work.im;
  }
  const std::span<const float> x = inverse_of(re, im);
  return {x.begin(), x.end()};
}

std::span<const float> RealFft::inverse_of_product_conj(const Spectrum& a, const Spectrum& b) {
  Workspace& work = workspace_for(n_);
  const std::size_t h = n_ / 2;
  const std::size_t n = std::min({a.size(), b.size(), h});
  product_conj(a, b, n, work.re, work.im);
  std::fill(work.re + n, work.re + h, 0.0F);
  std::fill(work.im + n, work.im + h, 0.0F);
  return inverse_of(work.re, work.im);
}

std::span<const float> RealFft::inverse(std::span<const float> re, std::span<const float> im) const {
  assert(re.size() == n_ / 2 && im.size() == n_ / 2);
  return inverse_of(re.data(), im.data());
}

std::span<const float> RealFft::inverse_of(const float* re, const float* im) const {
  const std::size_t h = n_ / 2;
  const Plan& plan = *plan_;
  Workspace& work = workspace_for(n_);
  work.in[0] = work.in[1] = 0.0F;
  pack_even_and_odd(re, im, plan.cosine.data(), plan.sine.data(),
                    static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_))), work.in, h);
  fftwf_execute_dft(plan.inverse.get(), as_complex(work.in), as_complex(work.out));
  return {work.out, n_};
}

}  // namespace bouncelab::audio
