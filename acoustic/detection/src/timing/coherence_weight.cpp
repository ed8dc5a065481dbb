// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/coherence_weight.hpp"

#include <algorithm>

namespace bouncelab::detection {
namespace {

constexpr std::size_t kAround = 8;   // bins on either side
constexpr double kNoiseShare = 0.5;  // what 17 bins of noise reach at one and a half standard deviations

}  // namespace

std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b) {
  const std::size_t n = a.size();
  std::vector<double> common(n + 1, 0.0), all(n + 1, 0.0);  // running sums
  const double weight = weight_a + weight_b;
  for (std::size_t k = 0; k < n; ++k) {
    const double re = static_cast<double>(a.re[k]) + b.re[k];
    const double im = static_cast<double>(a.im[k]) + b.im[k];
    const double product = static_cast<double>(a.re[k]) * b.re[k] + static_cast<double>(a.im[k]) * b.im[k];
    common[k + 1] = common[k] + product / (weight_a * weight_b);
    all[k + 1] = all[k] + (re * re + im * im) / (weight * weight);
  }
  std::vector<float> weights(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t from = k > kAround ? k - kAround : 0;
    const std::size_t to = std::min(n, k + kAround + 1);
    const double ratio = (common[to] - common[from]) / (all[to] - all[from] + 1e-30);
    weights[k] = static_cast<float>(std::clamp((ratio - kNoiseShare) / (1.0 - kNoiseShare), 0.0, 1.0));
  }
  return weights;
}

}  // namespace bouncelab::detection
