// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/converter.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
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
constexpr double kConverterBeta = 10.06;  // 100 dB: 0.1102 (100 - 8.7)

double windowed_sinc(double u) {
  const double x = u / ConverterFilter::kHalfWidth_samples;
  if (std::abs(x) > 1.0) return 0.0;
  const double argument = 2.0 * kPi * kCutoff * u;
  const double sinc = u == 0.0 ? 1.0 : sin(argument) / argument;
  // Kaiser's window less its pedestal (3e-4 of its height): without a step at its ends, quadrature over them is exact
  static const double pedestal = kaiser_window(1.0, kConverterBeta);
  return 2.0 * kCutoff * sinc * (kaiser_window(x, kConverterBeta) - pedestal);
}

}  // namespace

ConverterFilter::ConverterFilter() : table_(windowed_sinc, kHalfWidth_samples) {
  table_.scale_by(1.0 / table_.integral());
}

namespace {

/// Mutually prime at 48 kHz, so that echoes do not coincide.
constexpr std::array<double, 8> kLengths_s{11.10e-3, 13.52e-3, 16.23e-3, 19.31e-3,
                                           22.77e-3, 26.69e-3, 31.40e-3, 36.77e-3};

/// Orthogonal mixing: Hadamard's matrix over sqrt 8, in three rounds of sums and differences.
void mix(std::array<double, 8>& x) {
  for (std::size_t half = 1; half < 8; half *= 2)
    for (std::size_t start = 0; start < 8; start += 2 * half)
      for (std::size_t k = start; k < start + half; ++k) {
        const double sum = x[k] + x[k + half], difference = x[k] - x[k + half];
        x[k] = sum;
        x[k + half] = difference;
      }
  for (double& value : x) value *= 0.35355339059327373;
}

}  // namespace

ReverberationTail::ReverberationTail(const Reverberation& room, double rate_hz) {
  if (room.level_db <= -200.0) return;
  for (std::size_t k = 0; k < kLines; ++k) {
    lengths_[k] = static_cast<std::size_t>(std::lround(kLengths_s[k] * rate_hz));
    losses_[k] = pow(10.0, -3.0 * kLengths_s[k] / room.decay_60db_s);
  }
  memory_frames_ = static_cast<std::int64_t>(3.0 * room.decay_60db_s * rate_hz);
  // the level by trial: the tail of an impulse at gain 1
  input_gain_ = 1.0;
  std::vector<double> response(static_cast<std::size_t>(memory_frames_), 0.0);
  response.front() = 1.0;
  add_to(response);
  double energy = -1.0;
  for (const double h : response) energy += h * h;
  input_gain_ = std::sqrt(pow(10.0, room.level_db / 10.0) / energy);
}

void ReverberationTail::add_to(std::span<double> sound) const {
  if (!is_audible()) return;
  std::array<std::vector<double>, kLines> lines;
  for (std::size_t k = 0; k < kLines; ++k) lines[k].assign(lengths_[k], 0.0);
  std::array<std::size_t, kLines> at{};
  std::array<double, kLines> out{};
  for (double& sample : sound) {
    double tail = 0.0;
    for (std::size_t k = 0; k < kLines; ++k) {
      out[k] = losses_[k] * lines[k][at[k]];
      tail += k % 2 == 0 ? out[k] : -out[k];
    }
    mix(out);
    const double direct = input_gain_ * sample;
    for (std::size_t k = 0; k < kLines; ++k) {
      lines[k][at[k]] = out[k] + direct;
      if (++at[k] == lengths_[k]) at[k] = 0;
    }
    sample += tail;
  }
}

}  // namespace bouncelab::synthesis
