// SPDX-License-Identifier: GPL-3.0-or-later
#include "fourier.hpp"

#include <fftw3.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <type_traits>

#include "bouncelab/core/units.hpp"
#include "products.hpp"
#include "vector_clones.hpp"

namespace bouncelab {
namespace {

struct DestroyPlan {
  void operator()(fftwf_plan plan) const { fftwf_destroy_plan(plan); }
};
using Plan = std::unique_ptr<std::remove_pointer_t<fftwf_plan>, DestroyPlan>;

/// A real signal of length n is transformed as a complex one of length n/2, for which FFTW has the faster code.
struct Half {
  Plan forward, inverse;
  std::vector<float> cosine, sine;  // of 2 pi k / n, k = 0 ... n/2 - 1
};

/// FFTW plans one at a time and only by estimate, since what it measures differs from run to run.
const Half& half_of(std::size_t n, fftwf_complex* in, fftwf_complex* out) {
  static std::mutex mutex;
  static std::map<std::size_t, Half> known;
  const std::lock_guard lock(mutex);
  Half& half = known[n];
  if (half.forward == nullptr) {
    const auto size = static_cast<int>(n / 2);
    half.forward.reset(fftwf_plan_dft_1d(size, in, out, FFTW_FORWARD, FFTW_ESTIMATE));
    half.inverse.reset(fftwf_plan_dft_1d(size, in, out, FFTW_BACKWARD, FFTW_ESTIMATE));
    for (int k = 0; k < size; ++k) {
      const double phase = 2.0 * kPi * k / static_cast<double>(n);
      half.cosine.push_back(static_cast<float>(std::cos(phase)));
      half.sine.push_back(static_cast<float>(std::sin(phase)));
    }
  }
  return half;
}

BOUNCELAB_VECTOR_CLONES void part(const float* z, float* re, float* im, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) {
    re[k] = z[2 * k];
    im[k] = z[2 * k + 1];
  }
}

/// X[k] = E[k] + exp(-2 pi i k / n) O[k], E and O the transforms of the even and odd samples, which Z = E + i O holds.
/// @param h  n / 2; z_re and z_im hold h + 1, the last as the first
BOUNCELAB_VECTOR_CLONES void untangle(const float* z_re, const float* z_im, const float* cosine, const float* sine,
                                      float scale, float* __restrict re, float* __restrict im, std::size_t h) {
  for (std::size_t k = 0; k < h; ++k) {
    const float even_re = z_re[k] + z_re[h - k];
    const float even_im = z_im[k] - z_im[h - k];
    const float odd_re = z_im[k] + z_im[h - k];
    const float odd_im = z_re[h - k] - z_re[k];
    re[k] = scale * (even_re + (cosine[k] * odd_re + sine[k] * odd_im));
    im[k] = scale * (even_im + (cosine[k] * odd_im - sine[k] * odd_re));
  }
}

/// The other way, Z = E + i O.
/// @param re, im  h + 1 bins, the first and the last 0
BOUNCELAB_VECTOR_CLONES void tangle(const float* re, const float* im, const float* cosine, const float* sine,
                                    float scale, float* z, std::size_t h) {
  for (std::size_t k = 0; k < h; ++k) {
    const float even_re = re[k] + re[h - k];
    const float even_im = im[k] - im[h - k];
    const float turned_re = re[k] - re[h - k];
    const float turned_im = im[k] + im[h - k];
    z[2 * k] = scale * (even_re - (sine[k] * turned_re + cosine[k] * turned_im));
    z[2 * k + 1] = scale * (even_im + (cosine[k] * turned_re - sine[k] * turned_im));
  }
}

BOUNCELAB_VECTOR_CLONES void multiply(const float* ar, const float* ai, float sign, const float* br, const float* bi,
                                      float* re, float* im, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) {
    const float a_im = sign * ai[k];
    re[k] = ar[k] * br[k] - a_im * bi[k];
    im[k] = ar[k] * bi[k] + a_im * br[k];
  }
}

struct Phasor {
  double c = 1.0;
  double s = 0.0;
};

Phasor times(Phasor a, Phasor b) { return {a.c * b.c - a.s * b.s, a.c * b.s + a.s * b.c}; }

/// exp(i j angle) for one block of j, and for the block's length: one sine and cosine in all.
struct Steps {
  static constexpr std::size_t kBlock = 32;
  std::array<float, kBlock> c, s;
  Phasor block;

  explicit Steps(double angle) {
    std::array<Phasor, kBlock + 1> p;
    p[1] = {std::cos(angle), std::sin(angle)};
    for (std::size_t j = 2; j <= kBlock; ++j) p[j] = times(p[j / 2], p[j - j / 2]);  // errors grow with log j
    for (std::size_t j = 0; j < kBlock; ++j) {
      c[j] = static_cast<float>(p[j].c);
      s[j] = static_cast<float>(p[j].s);
    }
    block = p[kBlock];
  }
};

/// Of one block: (a_re + i a_im) exp(i j angle) times the block's own phasor.
BOUNCELAB_VECTOR_CLONES void turn(const float* a_re, const float* a_im, const Steps& steps, float c, float s,
                                  float* __restrict re, float* __restrict im, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    const float here_c = c * steps.c[j] - s * steps.s[j];
    const float here_s = c * steps.s[j] + s * steps.c[j];
    re[j] = a_re[j] * here_c - a_im[j] * here_s;
    im[j] = a_re[j] * here_s + a_im[j] * here_c;
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
    : n_(n),
      in_(fftwf_malloc(n * sizeof(float))),
      out_(fftwf_malloc(n * sizeof(float))),
      re_(n / 2 + 1, 0.0F),
      im_(n / 2 + 1, 0.0F),
      half_(&half_of(n, static_cast<fftwf_complex*>(in_.get()), static_cast<fftwf_complex*>(out_.get()))) {
  assert(n >= 4 && n % 2 == 0);
}

Spectrum Fourier::forward(std::span<const float> x) {
  assert(x.size() <= n_);
  const std::size_t h = n_ / 2;
  const Half& half = *static_cast<const Half*>(half_);
  auto* in = static_cast<float*>(in_.get());
  auto* out = static_cast<float*>(out_.get());
  std::fill(std::copy(x.begin(), x.end(), in), in + n_, 0.0F);
  fftwf_execute_dft(half.forward.get(), static_cast<fftwf_complex*>(in_.get()),
                    static_cast<fftwf_complex*>(out_.get()));
  part(out, re_.data(), im_.data(), h);
  re_[h] = re_[0];
  im_[h] = im_[0];
  Spectrum spectrum{std::vector<float>(h + 1, 0.0F), std::vector<float>(h + 1, 0.0F)};
  untangle(re_.data(), im_.data(), half.cosine.data(), half.sine.data(),
           static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_))), spectrum.re.data(), spectrum.im.data(), h);
  spectrum.re[0] = spectrum.im[0] = 0.0F;
  return spectrum;
}

std::vector<float> Fourier::inverse(const Spectrum& spectrum) {
  const std::size_t h = n_ / 2;
  const Half& half = *static_cast<const Half*>(half_);
  const auto known = static_cast<std::ptrdiff_t>(std::min(spectrum.size(), h));
  const auto fill = [&](const std::vector<float>& from, std::vector<float>& to) {
    std::fill(std::copy_n(from.begin(), known, to.begin()), to.end(), 0.0F);
    to[0] = 0.0F;
  };
  fill(spectrum.re, re_);
  fill(spectrum.im, im_);
  tangle(re_.data(), im_.data(), half.cosine.data(), half.sine.data(),
         static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_))), static_cast<float*>(in_.get()), h);
  fftwf_execute_dft(half.inverse.get(), static_cast<fftwf_complex*>(in_.get()),
                    static_cast<fftwf_complex*>(out_.get()));
  const auto* out = static_cast<const float*>(out_.get());
  return {out, out + n_};
}

std::size_t power_of_two(std::size_t n) {
  std::size_t power = 4;
  while (power < n) power *= 2;
  return power;
}

Spectrum turned(const Spectrum& a, double angle) {
  Spectrum out{std::vector<float>(a.size()), std::vector<float>(a.size())};
  const Steps steps(angle);
  Phasor here;
  for (std::size_t k = 0; k < a.size(); k += Steps::kBlock) {
    turn(&a.re[k], &a.im[k], steps, static_cast<float>(here.c), static_cast<float>(here.s), &out.re[k], &out.im[k],
         std::min(Steps::kBlock, a.size() - k));
    here = times(here, steps.block);  // n / 32 roundings of doubles: nothing to a float
  }
  return out;
}

Spectrum phasors(std::size_t n, double angle) {
  return turned({std::vector<float>(n, 1.0F), std::vector<float>(n, 0.0F)}, angle);
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
