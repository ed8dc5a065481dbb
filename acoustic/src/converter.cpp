// SPDX-License-Identifier: GPL-3.0-or-later
#include "converter.hpp"

#include <cmath>

#include "bouncelab/core/units.hpp"

namespace bouncelab {
namespace {

constexpr double kCutoff = 0.45;
constexpr double kBeta = 10.06;  // 100 dB: 0.1102 (100 - 8.7)

double windowed_sinc(double u) {
  const double x = u / ConverterFilter::kHalfWidth_samples;
  if (std::abs(x) > 1.0) return 0.0;
  const double argument = 2.0 * kPi * kCutoff * u;
  const double sinc = u == 0.0 ? 1.0 : std::sin(argument) / argument;
  // Kaiser's window less its pedestal (3e-4 of its height): without a step at its ends, quadrature over them is exact
  const double window =
      (std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - x * x)) - 1.0) / (std::cyl_bessel_i(0.0, kBeta) - 1.0);
  return 2.0 * kCutoff * sinc * window;
}

}  // namespace

ConverterFilter::ConverterFilter() {
  const int n = static_cast<int>(kHalfWidth_samples) * kPerSample;
  for (int k = -1; k <= n + 2; ++k) table_.push_back(windowed_sinc(static_cast<double>(k) / kPerSample));
  double integral = table_[1];
  for (int k = 1; k < n; ++k) integral += 2.0 * table_[static_cast<std::size_t>(k + 1)];
  for (double& value : table_) value *= kPerSample / integral;
}

}  // namespace bouncelab
