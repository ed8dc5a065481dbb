// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/converter.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::synthesis {

KernelTable::KernelTable(const std::function<double(double)>& h, int half_width)
    : half_width_(half_width), n_row_(2 * half_width + 1) {
  for (int phase = -1; phase <= kPhases + 1; ++phase)
    for (int j = 0; j < n_row_; ++j) table_.push_back(h(j - half_width_ + static_cast<double>(phase) / kPhases));
}

double KernelTable::integral() const {
  double sum = 0.0;
  for (const double* value = row(0); value != row(kPhases); ++value) sum += *value / kPhases;
  return sum;
}

void KernelTable::scale_by(double factor) {
  for (double& value : table_) value *= factor;
}

void KernelTable::add(double offset_samples, double weight, std::span<double> samples) const {
  // n + offset = j - W + fraction: the fraction, and with it the interpolation, is the same for all n
  const double whole = std::floor(offset_samples);
  const double position = (offset_samples - whole) * kPhases;
  const int phase = static_cast<int>(position);
  const double t = position - phase;
  const double weights[4] = {weight * t * (-0.5 + t * (1.0 - 0.5 * t)), weight * (1.0 + t * t * (1.5 * t - 2.5)),
                             weight * t * (0.5 + t * (2.0 - 1.5 * t)), weight * t * t * (0.5 * t - 0.5)};
  const auto shift = static_cast<std::ptrdiff_t>(whole) + half_width_;  // j = n + shift
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -shift);
  const std::ptrdiff_t last = std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(samples.size()), n_row_ - shift);
  if (first >= last) return;
  const std::ptrdiff_t j = first + shift;
  const double* const rows[4] = {row(phase - 1) + j, row(phase) + j, row(phase + 1) + j, row(phase + 2) + j};
  audio::add_four_scaled(samples.data() + first, weights, rows, static_cast<std::size_t>(last - first));
}

namespace {

constexpr double kCutoff = 0.45;
constexpr double kBeta = 10.06;  // 100 dB: 0.1102 (100 - 8.7)

double windowed_sinc(double u) {
  const double x = u / ConverterFilter::kHalfWidth_samples;
  if (std::abs(x) > 1.0) return 0.0;
  const double argument = 2.0 * kPi * kCutoff * u;
  const double sinc = u == 0.0 ? 1.0 : sin(argument) / argument;
  // Kaiser's window less its pedestal (3e-4 of its height): without a step at its ends, quadrature over them is exact
  static const double pedestal = kaiser_window(1.0, kBeta);
  return 2.0 * kCutoff * sinc * (kaiser_window(x, kBeta) - pedestal);
}

}  // namespace

ConverterFilter::ConverterFilter() : table_(windowed_sinc, kHalfWidth_samples) {
  table_.scale_by(1.0 / table_.integral());
}

}  // namespace bouncelab::synthesis
