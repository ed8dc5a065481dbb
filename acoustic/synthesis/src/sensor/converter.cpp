// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/converter.hpp"

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

#include <cmath>

namespace bouncelab::synthesis {
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
