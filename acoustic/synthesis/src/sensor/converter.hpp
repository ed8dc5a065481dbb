// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "sensor/kernel_table.hpp"

namespace bouncelab::synthesis {

/// The anti-alias filter of the analogue-to-digital converter: linear phase, no delay, in continuous time.
///
///   h(u) = 2 f_c sinc(2 f_c u) (Kaiser_beta(u / W) - pedestal),  |u| <= W = 34,  f_c = 0.45,  beta = 10.06
///
/// Passes up to 0.40 of the sample rate within 2e-5, stops everything from 0.50 by 98 dB: after it, samples hold the
/// whole wave, and a shift of the impact by a fraction of a sample is a shift of phase. u in samples; unit integral.
/// Source: Kaiser's design rule, Oppenheim & Schafer, Discrete-Time Signal Processing (3rd ed. 2010), 7.5.3.
class ConverterFilter {
 public:
  static constexpr int kHalfWidth_samples = 34;

  ConverterFilter();
  /// Adds weight h(n + offset) to samples[n], for all n, within 1e-8 of its peak.
  void add(double offset_samples, double weight, std::span<double> samples) const {
    table_.add(offset_samples, weight, samples);
  }

 private:
  KernelTable table_;
};

}  // namespace bouncelab::synthesis
