// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/kernel_table.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/audio/dsp/kernels.hpp"

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

}  // namespace bouncelab::synthesis
