// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>

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

/// product[k] = a[k] b[k] for n values.
void multiply(const double* a, const double* b, double* product, std::size_t n);

/// FIR filter, not reversed: out[n] = sum_k taps[k] x[n + k]. Every sum is taken in the same order, wherever it stands
/// in `out`; by fused multiply-add where the processor has it.
/// @param x     at least out.size() + taps.size() - 1 samples
/// @param taps  at least one
void correlate(std::span<const float> x, std::span<const float> taps, std::span<float> out);

/// The same at every factor-th place: out[n] = sum_k taps[k] x[factor n + k], without fused multiply-add; every sum is
/// taken in the same order, wherever it stands in `out`.
/// @param x     at least factor (out.size() - 1) + taps.size() samples
/// @param taps  a multiple of 16
void filter_and_decimate(std::span<const float> x, std::size_t factor, std::span<const float> taps,
                         std::span<float> out);

}  // namespace bouncelab::audio
