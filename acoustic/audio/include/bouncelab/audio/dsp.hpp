// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Sums and products of arrays, for detection and synthesis. Partial sums side by side let the processor add while it
/// waits for the addition before; tests/bench/kernels_bench.cpp prints each against a plain loop.
namespace bouncelab::audio {

/// Sum of products over the shorter of both; 32 partial sums in single precision.
double dot(std::span<const float> a, std::span<const float> b);
/// Sum of products, n of each; 8 partial sums.
double dot(const double* a, const double* b, std::size_t n);

/// Largest of the values, none of them NaN; -infinity where there are none.
float largest(std::span<const float> x);

/// to[k] += factor x[k] for n values.
void add_scaled(float* to, float factor, const float* x, std::size_t n);
void add_scaled(double* to, double factor, const double* x, std::size_t n);
/// to[k] += (f_0 x_0[k] + f_1 x_1[k]) + (f_2 x_2[k] + f_3 x_3[k]) for n values: `to` is loaded and stored once.
void add_four_scaled(double* to, const double factors[4], const double* const x[4], std::size_t n);

/// FIR filter, not reversed: out[n] = sum_k taps[k] x[n + k]. Every sum is taken in the same order, wherever it stands
/// in `out`; by fused multiply-add where the processor has it.
/// @param x     at least out.size() + taps.size() - 1 samples
/// @param taps  at least one
void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out);

/// Spectrum of a real signal, bins 0 ... n/2.
struct Spectrum {
  std::vector<float> re;
  std::vector<float> im;
  std::size_t size() const { return re.size(); }
};

/// Fourier transform of a real signal of one length. Costs nothing to make.
///
///   X[k] = sqrt(2/n) sum_j x[j] exp(-2 pi i j k / n)
///
/// X[0] and X[n/2] are set to 0, so that Re sum_k conj(X[k]) Y[k] = sum_j x[j] y[j] for what has neither, and noise of
/// variance 1 has variance 1 in each real and imaginary part.
class RealFft {
 public:
  /// @param n  even, >= 4
  explicit RealFft(std::size_t n);
  std::size_t size() const { return n_; }
  /// @param x  at most n samples; what is missing is 0
  Spectrum forward(std::span<const float> x) const;
  /// The same into a spectrum that has memory already.
  void forward(std::span<const float> x, Spectrum& spectrum) const;
  /// n samples; bins that are missing are 0
  std::vector<float> inverse(const Spectrum& spectrum) const;
  /// The same samples, until the thread's next transform: nothing is copied.
  std::span<const float> inverse(std::span<const float> re, std::span<const float> im) const;

  struct Plan;

 private:
  std::size_t n_;
  const Plan* plan_;  // made once for each length and kept
};

/// a[k] exp(i k angle), the phasor to 1e-6: the signal earlier by angle n / (2 pi) samples, n those of its transform.
Spectrum phase_shifted(const Spectrum& a, double angle);

/// conj(a) b
Spectrum product_conj(const Spectrum& a, const Spectrum& b);
/// conj(a[k]) b[k] exp(i k angle) of bins 0 ... n - 1, which both have; the phasor to 1e-6
Spectrum product_conj(const Spectrum& a, const Spectrum& b, std::size_t n, double angle);
/// a += factor b
void add_scaled(Spectrum& a, const Spectrum& b, double factor);
/// sum |a|^2
double energy(const Spectrum& a);
/// |a_k|^2
inline double bin_power(const Spectrum& a, std::size_t k) {
  return static_cast<double>(a.re[k]) * a.re[k] + static_cast<double>(a.im[k]) * a.im[k];
}

}  // namespace bouncelab::audio
