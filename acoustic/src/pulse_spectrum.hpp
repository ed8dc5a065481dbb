// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

namespace bouncelab {

/// Spectrum P(x) of a contact's force pulse about its middle, x = frequency times duration, P(0) = 1, with its slope.
/// A contact multiplies what a blow without duration would sound like by it: longer contacts sound duller.
class PulseSpectrum {
 public:
  static constexpr double kLargest = 4.0;  ///< x; beyond, value and slope are 0

  /// An elastic sphere on a half-space (Johnson, Contact Mechanics (1985), 11.4).
  static const PulseSpectrum& hertz();
  /// cos(pi x) / (1 - 4 x^2): contacts whose stiffness does not grow with indentation. Source: Reed, J. Phys. D 18,
  /// 2241 (1985), doi:10.1088/0022-3727/18/11/011.
  static const PulseSpectrum& half_sine();

  /// out[k] = P(k step), slope[k] = P'(k step), by linear interpolation in steps of 1/512: to 1e-5.
  void tabulate(double step, std::vector<float>& value, std::vector<float>& slope) const;

 private:
  explicit PulseSpectrum(double (*force)(double));
  std::vector<float> value_;
  std::vector<float> slope_;
};

}  // namespace bouncelab
