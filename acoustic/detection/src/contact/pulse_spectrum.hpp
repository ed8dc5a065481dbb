// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

namespace bouncelab::detection {

/// Spectrum P(x) of a contact's force pulse about its middle, x = frequency times duration, P(0) = 1, with its slope.
/// The sound of an impact is that of an impulse multiplied by it: longer contacts have less at high frequencies.
class PulseSpectrum {
 public:
  static constexpr double kLargest = 4.0;  ///< x; beyond, value and slope are 0

  /// An elastic sphere on a half-space (Johnson, Contact Mechanics (1985), 11.4).
  static const PulseSpectrum& hertz();
  /// cos(pi x) / (1 - 4 x^2): contacts whose stiffness does not grow with indentation. Source: Reed, J. Phys. D 18,
  /// 2241 (1985), doi:10.1088/0022-3727/18/11/011.
  static const PulseSpectrum& half_sine();

  struct Value {
    double value = 0.0;
    double slope = 0.0;
  };
  /// P(x) and P'(x) for x >= 0, by linear interpolation in steps of 1/512: to 1e-5.
  Value at(double x) const {
    const double place = x * kPerUnit;
    const auto index = static_cast<std::size_t>(place);
    if (index + 1 >= table_.size()) return {};
    const double part = place - static_cast<double>(index);
    const Value& a = table_[index];
    const Value& b = table_[index + 1];
    return {a.value + part * (b.value - a.value), a.slope + part * (b.slope - a.slope)};
  }

 private:
  explicit PulseSpectrum(double (*force)(double));
  static constexpr double kPerUnit = 512.0;
  std::vector<Value> table_;
};

}  // namespace bouncelab::detection
