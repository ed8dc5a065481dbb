// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/pulse_spectrum.hpp"

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

double half_sine_force(double s) { return 0.5 * kPi * sin(kPi * s); }

}  // namespace

PulseSpectrum::PulseSpectrum(double (*force)(double)) {
  // the trapezoidal rule over theta, s = (1 - cos theta)/2, where force ds/dtheta is smooth and periodic
  // (but for a half-sine's ends: 48 nodes leave 3e-7); both pulses are symmetric about the middle
  constexpr int kAll = 48;
  constexpr int kNodes = kAll / 2;
  std::vector<double> middle_out(kNodes), weight(kNodes);
  double total = 0.0;
  for (int q = 0; q < kNodes; ++q) {
    const double theta = kPi * (q + 0.5) / kAll;
    middle_out[q] = -0.5 * cos(theta);
    weight[q] = sin(theta) * force(0.5 + middle_out[q]);
    total += weight[q];
  }
  // each node's phasor advances by its own angle from x to x: 2048 roundings
  std::vector<double> slope_weight(kNodes), c(kNodes, 1.0), s(kNodes, 0.0), turn_c(kNodes), turn_s(kNodes);
  for (int q = 0; q < kNodes; ++q) {
    const double phase = 2.0 * kPi * middle_out[q];
    weight[q] /= total;
    slope_weight[q] = -weight[q] * phase;
    turn_c[q] = cos(phase / kPerUnit);
    turn_s[q] = sin(phase / kPerUnit);
  }
  for (int k = 0; k <= static_cast<int>(kLargest * kPerUnit); ++k) {
    double value = 0.0, slope = 0.0;
    for (int q = 0; q < kNodes; ++q) {
      value += weight[q] * c[q];
      slope += slope_weight[q] * s[q];
    }
    for (int q = 0; q < kNodes; ++q) {
      const double next_c = c[q] * turn_c[q] - s[q] * turn_s[q];
      s[q] = c[q] * turn_s[q] + s[q] * turn_c[q];
      c[q] = next_c;
    }
    table_.push_back({value, slope});
  }
}

const PulseSpectrum& PulseSpectrum::hertz() {
  static const PulseSpectrum spectrum(hertz_force);
  return spectrum;
}

const PulseSpectrum& PulseSpectrum::half_sine() {
  static const PulseSpectrum spectrum(half_sine_force);
  return spectrum;
}

}  // namespace bouncelab::detection
