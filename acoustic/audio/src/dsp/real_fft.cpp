// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/real_fft.hpp"

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

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/vector_clones.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::audio {
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

/// Where transforms of up to n samples are made; one for each thread, so that none has to be allotted for each.
struct Room {
  float* in = nullptr;  // n
  float* out = nullptr;
  float* re = nullptr;  // n / 2 + 1
  float* im = nullptr;
};

Room& room_for(std::size_t n) {
  struct Free {
    void operator()(void* p) const { fftwf_free(p); }
  };
  thread_local std::unique_ptr<float, Free> held;
  thread_local std::size_t n_held = 0;
  thread_local Room room;
  if (n > n_held) {
    constexpr std::size_t kAligned = 32;  // floats
    const std::size_t n_part = (n / 2 + 1 + kAligned) / kAligned * kAligned;
    const std::size_t n_whole = (n + kAligned) / kAligned * kAligned;
    held.reset(static_cast<float*>(fftwf_malloc(2 * (n_whole + n_part) * sizeof(float))));
    if (held == nullptr) throw std::bad_alloc();
    n_held = n;
    room.in = held.get();
    room.out = room.in + n_whole;
    room.re = room.out + n_whole;
    room.im = room.re + n_part;
  }
  return room;
}

fftwf_complex* as_complex(float* x) { return reinterpret_cast<fftwf_complex*>(x); }

/// FFTW plans one at a time and only by estimate, since what it measures differs from run to run.
const Half& half_of(std::size_t n) {
  static std::mutex mutex;
  static std::map<std::size_t, Half> known;
  const std::lock_guard lock(mutex);
  Half& half = known[n];
  if (half.forward == nullptr) {
    const auto size = static_cast<int>(n / 2);
    const Room& room = room_for(n);
    half.forward.reset(fftwf_plan_dft_1d(size, as_complex(room.in), as_complex(room.out), FFTW_FORWARD, FFTW_ESTIMATE));
    half.inverse.reset(
        fftwf_plan_dft_1d(size, as_complex(room.in), as_complex(room.out), FFTW_BACKWARD, FFTW_ESTIMATE));
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

/// The other way, Z = E + i O, but for its first value.
/// @param re, im  h bins, the first of no account
BOUNCELAB_VECTOR_CLONES void tangle(const float* re, const float* im, const float* cosine, const float* sine,
                                    float scale, float* z, std::size_t h) {
  for (std::size_t k = 1; k < h; ++k) {
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

/// a[k] exp(i k angle), block by block.
BOUNCELAB_VECTOR_CLONES void phase_shift(const float* a_re, const float* a_im, const Steps& steps, float* __restrict re,
                                         float* __restrict im, std::size_t n) {
  double block_c = 1.0;  // n / 32 roundings of doubles: nothing to a float
  double block_s = 0.0;
  for (std::size_t k = 0; k < n; k += Steps::kBlock) {
    const auto c = static_cast<float>(block_c);
    const auto s = static_cast<float>(block_s);
    const std::size_t n_here = std::min(Steps::kBlock, n - k);
    for (std::size_t j = 0; j < n_here; ++j) {
      const float here_c = c * steps.c[j] - s * steps.s[j];
      const float here_s = c * steps.s[j] + s * steps.c[j];
      re[k + j] = a_re[k + j] * here_c - a_im[k + j] * here_s;
      im[k + j] = a_re[k + j] * here_s + a_im[k + j] * here_c;
    }
    const double next_c = block_c * steps.block.c - block_s * steps.block.s;
    block_s = block_c * steps.block.s + block_s * steps.block.c;
    block_c = next_c;
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

RealFft::RealFft(std::size_t n) : n_(n), half_(&half_of(n)) { assert(n >= 4 && n % 2 == 0); }

Spectrum RealFft::forward(std::span<const float> x) {
  assert(x.size() <= n_);
  const std::size_t h = n_ / 2;
  const Half& half = *static_cast<const Half*>(half_);
  Room& room = room_for(n_);
  std::fill(std::copy(x.begin(), x.end(), room.in), room.in + n_, 0.0F);
  fftwf_execute_dft(half.forward.get(), as_complex(room.in), as_complex(room.out));
  part(room.out, room.re, room.im, h);
  room.re[h] = room.re[0];
  room.im[h] = room.im[0];
  Spectrum spectrum{std::vector<float>(h + 1), std::vector<float>(h + 1)};
  untangle(room.re, room.im, half.cosine.data(), half.sine.data(),
           static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_))), spectrum.re.data(), spectrum.im.data(), h);
  spectrum.re[0] = spectrum.im[0] = 0.0F;
  return spectrum;
}

std::vector<float> RealFft::inverse(const Spectrum& spectrum) {
  const std::size_t h = n_ / 2;
  const Half& half = *static_cast<const Half*>(half_);
  Room& room = room_for(n_);
  const float* re = spectrum.re.data();
  const float* im = spectrum.im.data();
  if (spectrum.size() < h) {
    std::fill(std::copy(spectrum.re.begin(), spectrum.re.end(), room.re), room.re + h, 0.0F);
    std::fill(std::copy(spectrum.im.begin(), spectrum.im.end(), room.im), room.im + h, 0.0F);
    re = room.re;
    im = room.im;
  }
  room.in[0] = room.in[1] = 0.0F;
  tangle(re, im, half.cosine.data(), half.sine.data(), static_cast<float>(std::sqrt(0.5 / static_cast<double>(n_))),
         room.in, h);
  fftwf_execute_dft(half.inverse.get(), as_complex(room.in), as_complex(room.out));
  return {room.out, room.out + n_};
}

Spectrum phase_shifted(const Spectrum& a, double angle) {
  Spectrum out{std::vector<float>(a.size()), std::vector<float>(a.size())};
  phase_shift(a, angle, out);
  return out;
}

void phase_shift(const Spectrum& a, double angle, Spectrum& out) {
  phase_shift(a.re.data(), a.im.data(), Steps(angle), out.re.data(), out.im.data(), a.size());
}

Spectrum phase_ramp(std::size_t n, double angle) {
  return phase_shifted({std::vector<float>(n, 1.0F), std::vector<float>(n, 0.0F)}, angle);
}

Spectrum product_conj(const Spectrum& a, const Spectrum& b) { return multiplied(a, -1.0F, b); }
Spectrum product(const Spectrum& a, const Spectrum& b) { return multiplied(a, 1.0F, b); }

void add_scaled(Spectrum& a, const Spectrum& b, double factor) {
  const auto f = static_cast<float>(factor);
  add(a.re.data(), b.re.data(), f, std::min(a.size(), b.size()));
  add(a.im.data(), b.im.data(), f, std::min(a.size(), b.size()));
}

double energy(const Spectrum& a) { return dot(a.re, a.re) + dot(a.im, a.im); }

}  // namespace bouncelab::audio
