// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace bouncelab {

/// The anti-alias filter of the analogue-to-digital converter: linear phase, no delay, in continuous time.
///
///   h(u) = 2 f_c sinc(2 f_c u) (Kaiser_beta(u / W) - pedestal),  |u| <= W = 34,  f_c = 0.45,  beta = 10.06
///
/// Passes up to 0.40 of the sample rate within 2e-5, stops everything from 0.50 by 98 dB: after it, samples hold the
/// whole wave, and a shift of the impact by a fraction of a sample is a shift of phase. u in samples; unit integral.
/// Source: Kaiser's design rule, Oppenheim & Schafer, Discrete-Time Signal Processing (3rd ed. 2010), 7.5.3.
class ConverterFilter {
 public:
  static constexpr double kHalfWidth_samples = 34.0;
  static constexpr double kPassband = 0.40;  ///< of the sample rate

  ConverterFilter();
  /// h(u), from a table by cubic interpolation, within 1e-8 of its peak.
  double operator()(double u_samples) const {
    const double position = (u_samples < 0.0 ? -u_samples : u_samples) * kPerSample;
    if (position >= kHalfWidth_samples * kPerSample) return 0.0;
    const int k = static_cast<int>(position);
    const double t = position - k;
    const double* h = table_.data() + k;  // one entry before zero: h(-1/kPerSample) = h(1/kPerSample)
    const double c0 = h[1], c1 = 0.5 * (h[2] - h[0]);
    const double difference = h[2] - h[1];
    const double c3 = c1 + 0.5 * (h[3] - h[1]) - 2.0 * difference;
    const double c2 = difference - c1 - c3;
    return c0 + t * (c1 + t * (c2 + t * c3));
  }

 private:
  static constexpr int kPerSample = 256;
  std::vector<double> table_;
};

}  // namespace bouncelab
