// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp.hpp"

#include <fftw3.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <type_traits>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::audio {

// not in an anonymous namespace: RealFft::Plan has members of this type
struct DestroyPlan {
  void operator()(fftwf_plan plan) const { fftwf_destroy_plan(plan); }
};
using FftwPlan = std::unique_ptr<std::remove_pointer_t<fftwf_plan>, DestroyPlan>;

struct RealFft::Plan {
  FftwPlan forward, inverse;        // complex, of half the length
  std::vector<float> cosine, sine;  // of 2 pi k / n, k < n / 2
};

namespace {

/// Buffers of transforms of up to n samples, one set for each thread: n numbers each.
struct Workspace {
  float* samples = nullptr;
  float* bins = nullptr;
};

fftwf_complex* as_complex(float* x) { return reinterpret_cast<fftwf_complex*>(x); }

float* fftw_array(std::size_t n) {
  auto* const array = fftwf_alloc_real(n);
  if (array == nullptr) throw std::bad_alloc();
  return array;
}

struct FreeArray {
  void operator()(void* p) const { fftwf_free(p); }
};

Workspace& workspace_for(std::size_t n) {
  thread_local std::unique_ptr<float, FreeArray> samples, bins;
  thread_local std::size_t n_held = 0;
  thread_local Workspace work;
  if (n > n_held) {
    samples.reset(fftw_array(n));
    bins.reset(fftw_array(n));
    work = {samples.get(), bins.get()};
    n_held = n;
  }
  return work;
}

constexpr std::size_t kRoomToPlan = 1 << 22;  // floats, 16 MB: other threads may take most of it meanwhile

BOUNCELAB_VECTOR_CLONES void split(const float* __restrict z, std::size_t h, float* __restrict re,
                                   float* __restrict im) {
  for (std::size_t k = 0; k < h; ++k) {
    re[k] = z[2 * k];
    im[k] = z[2 * k + 1];
  }
}

/// Bins 1 ... h - 1 of n = 2 h real samples x from those of the complex z[j] = x[2j] + i x[2j+1], of length h, a + i b:
///   X[k] = (Z[k] + Z*[h-k]) / 2 - i exp(-2 pi i k / n) (Z[k] - Z*[h-k]) / 2
BOUNCELAB_VECTOR_CLONES void unpack(const float* __restrict a, const float* __restrict b, const RealFft::Plan& plan,
                                    float scale, std::size_t h, float* __restrict re, float* __restrict im) {
  const float *const c = plan.cosine.data(), *const s = plan.sine.data();
  for (std::size_t k = 1; k < h; ++k) {
    const float even_re = a[k] + a[h - k], even_im = b[k] - b[h - k];
    const float odd_re = b[k] + b[h - k], odd_im = a[h - k] - a[k];
    re[k] = 0.5F * scale * (even_re + c[k] * odd_re + s[k] * odd_im);
    im[k] = 0.5F * scale * (even_im + c[k] * odd_im - s[k] * odd_re);
  }
}

/// The other way round, without division by n: Z[k] = X[k] + X*[h-k] + i exp(2 pi i k / n) (X[k] - X*[h-k])
BOUNCELAB_VECTOR_CLONES void pack(const float* __restrict re, const float* __restrict im, const RealFft::Plan& plan,
                                  float scale, std::size_t h, float* __restrict z) {
  const float *const c = plan.cosine.data(), *const s = plan.sine.data();
  for (std::size_t k = 1; k < h; ++k) {
    const float even_re = re[k] + re[h - k], even_im = im[k] - im[h - k];
    const float odd_re = re[k] - re[h - k], odd_im = im[k] + im[h - k];
    z[2 * k] = scale * (even_re - c[k] * odd_im - s[k] * odd_re);
    z[2 * k + 1] = scale * (even_im + c[k] * odd_re - s[k] * odd_im);
  }
}

/// FFTW may plan on one thread at a time; by estimate only, because the plans that it measures differ from run to run.
/// FFTW's own real transforms, planned so, take longer than complex ones of half the length with packing: by them
/// `detect` takes 1.05 (60 s of sound) to 1.15 (12 s) of the time, all in all.
const RealFft::Plan& plan_for(std::size_t n) {
  static std::mutex mutex;
  static std::map<std::size_t, RealFft::Plan> known;
  const std::lock_guard lock(mutex);
  RealFft::Plan& plan = known[n];
  if (plan.forward == nullptr) {
    const Workspace& work = workspace_for(n);
    // a planner that gets no memory ends the process: whether there is some is asked before
    std::unique_ptr<float, FreeArray>(fftw_array(kRoomToPlan)).reset();
    const auto size = static_cast<int>(n / 2);
    fftwf_complex *const in = as_complex(work.samples), *const out = as_complex(work.bins);
    plan.forward.reset(fftwf_plan_dft_1d(size, in, out, FFTW_FORWARD, FFTW_ESTIMATE));
    plan.inverse.reset(fftwf_plan_dft_1d(size, out, in, FFTW_BACKWARD, FFTW_ESTIMATE));
    for (int k = 0; k < size; ++k) {
      const double phase = 2.0 * kPi * k / static_cast<double>(n);
      plan.cosine.push_back(static_cast<float>(cos(phase)));
      plan.sine.push_back(static_cast<float>(sin(phase)));
    }
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
  fftwf_execute_dft(plan_->forward.get(), as_complex(work.samples), as_complex(work.bins));
  spectrum.re.resize(h + 1);
  spectrum.im.resize(h + 1);
  const auto scale = static_cast<float>(std::sqrt(2.0 / static_cast<double>(n_)));
  split(work.bins, h, work.samples, work.samples + h);
  unpack(work.samples, work.samples + h, *plan_, scale, h, spectrum.re.data(), spectrum.im.data());
  spectrum.re[0] = spectrum.im[0] = spectrum.re[h] = spectrum.im[h] = 0.0F;
}

std::vector<float> RealFft::inverse(const Spectrum& spectrum) const {
  const std::span<const float> x = inverse(spectrum.re, spectrum.im);
  return {x.begin(), x.end()};
}

std::span<const float> RealFft::inverse(std::span<const float> re, std::span<const float> im) const {
  Workspace& work = workspace_for(n_);
  const std::size_t h = n_ / 2, n_bins = std::min(re.size(), h);
  std::fill_n(work.samples, n_, 0.0F);
  std::copy_n(re.begin(), n_bins, work.samples);
  std::copy_n(im.begin(), n_bins, work.samples + h);
  const auto scale = static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_)));
  pack(work.samples, work.samples + h, *plan_, scale, h, work.bins);
  work.bins[0] = work.bins[1] = 0.0F;
  fftwf_execute_dft(plan_->inverse.get(), as_complex(work.bins), as_complex(work.samples));
  return {work.samples, n_};
}

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

Spectrum of_size(std::size_t n) { return {std::vector<float>(n), std::vector<float>(n)}; }

}  // namespace

BOUNCELAB_VECTOR_CLONES Spectrum phase_shifted(const Spectrum& a, double angle) {
  Spectrum out = of_size(a.size());
  const float *const re = a.re.data(), *const im = a.im.data();
  const auto value = [=](std::size_t k, float& x, float& y) { x = re[k], y = im[k]; };
  times_phasors(value, PhaseSteps(angle), out.re.data(), out.im.data(), a.size());
  return out;
}

BOUNCELAB_VECTOR_CLONES Spectrum product_conj(const Spectrum& a, const Spectrum& b, std::size_t n, double angle) {
  Spectrum out = of_size(n);
  const float *const ar = a.re.data(), *const ai = a.im.data(), *const br = b.re.data(), *const bi = b.im.data();
  const auto value = [=](std::size_t k, float& x, float& y) {
    x = ar[k] * br[k] + ai[k] * bi[k];
    y = ar[k] * bi[k] - ai[k] * br[k];
  };
  times_phasors(value, PhaseSteps(angle), out.re.data(), out.im.data(), n);
  return out;
}

BOUNCELAB_VECTOR_CLONES Spectrum product_conj(const Spectrum& a, const Spectrum& b) {
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
