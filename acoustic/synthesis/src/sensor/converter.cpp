// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/converter.hpp"

#include "bouncelab/core/elementary.hpp"
#include "plate/bessel.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "bouncelab/audio/dsp/vector_clones.hpp"

namespace bouncelab::synthesis {
namespace {

constexpr double kCutoff = 0.45;
constexpr double kBeta = 10.06;  // 100 dB: 0.1102 (100 - 8.7)

double windowed_sinc(double u) {
  const double x = u / ConverterFilter::kHalfWidth_samples;
  if (std::abs(x) > 1.0) return 0.0;
  const double argument = 2.0 * std::numbers::pi * kCutoff * u;
  const double sinc = u == 0.0 ? 1.0 : sin(argument) / argument;
  // Kaiser's window less its pedestal (3e-4 of its height): without a step at its ends, quadrature over them is exact
  const double pedestal = 1.0 / bessel_i(0, kBeta);
  const double window = bessel_i(0, kBeta * std::sqrt(1.0 - x * x)) * pedestal;
  return 2.0 * kCutoff * sinc * (window - pedestal);
}

BOUNCELAB_VECTOR_CLONES void add_rows(const double* const rows[4], const double weights[4], std::ptrdiff_t n,
                                      double* out) {
  const double *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3];
  for (std::ptrdiff_t j = 0; j < n; ++j)
    out[j] += (weights[0] * a[j] + weights[1] * b[j]) + (weights[2] * c[j] + weights[3] * d[j]);
}

}  // namespace

ConverterFilter::ConverterFilter() {
  double integral = 0.0;
  for (int phase = -1; phase <= kPhases + 1; ++phase)
    for (int j = 0; j < kRow; ++j) {
      table_.push_back(windowed_sinc(j - kHalfWidth_samples + static_cast<double>(phase) / kPhases));
      if (phase >= 0 && phase < kPhases) integral += table_.back() / kPhases;
    }
  for (double& value : table_) value /= integral;
}

void ConverterFilter::add(double offset_samples, double weight, std::span<double> samples) const {
  // n + offset = j - W + fraction: the fraction, and with it the interpolation, is the same for all n
  const double whole = std::floor(offset_samples);
  const double position = (offset_samples - whole) * kPhases;
  const int phase = static_cast<int>(position);
  const double t = position - phase;
  const double weights[4] = {weight * t * (-0.5 + t * (1.0 - 0.5 * t)), weight * (1.0 + t * t * (1.5 * t - 2.5)),
                             weight * t * (0.5 + t * (2.0 - 1.5 * t)), weight * t * t * (0.5 * t - 0.5)};
  const auto shift = static_cast<std::ptrdiff_t>(whole) + kHalfWidth_samples;  // j = n + shift
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -shift);
  const std::ptrdiff_t last = std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(samples.size()), kRow - shift);
  if (first >= last) return;
  const std::ptrdiff_t j = first + shift;
  const double* const rows[4] = {row(phase - 1) + j, row(phase) + j, row(phase + 1) + j, row(phase + 2) + j};
  add_rows(rows, weights, last - first, samples.data() + first);
}

}  // namespace bouncelab::synthesis
