// SPDX-License-Identifier: GPL-3.0-or-later
#include "excitation/ringing_transform.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t kLength = 2 * RingingTransform::kFrames;  // M
constexpr std::size_t kBins = kLength / 2;
constexpr int kWidth = 12;  // w
constexpr int kHalfWidth = kWidth / 2;
constexpr double kBeta = 0.75 * std::numbers::pi * kWidth;
constexpr double kMiddle = 0.5 * RingingTransform::kFrames;
/// Within M / 2 frames, as exponent.
constexpr double kLargestDecay = 4.0;

/// I_0(sqrt x) by its power series, to rounding for the |x| <= (2 kBeta)^2 that occur.
Complex bessel_i0_of_root(const Complex& x) {
  Complex sum = 0.0, term = 1.0;
  for (int m = 1; m < 120; ++m) {
    sum += term;
    term *= 0.25 / (static_cast<double>(m) * m) * x;
  }
  return sum;
}

/// psi(n): w sinh(u) / u, u^2 = beta^2 - (pi w n / M)^2, which is positive where |n| <= M / 4.
double psi(double n) {
  const double x = std::numbers::pi * kWidth * n / kLength;
  const double u = std::sqrt(kBeta * kBeta - x * x);
  return kWidth * (exp(u) - exp(-u)) / (2.0 * u);
}

/// Numbers far from one another in turn.
std::vector<std::size_t> interleaved(const std::vector<std::size_t>& numbers) {
  constexpr std::size_t kApart = 8;
  std::vector<std::size_t> result;
  for (std::size_t first = 0; first < kApart; ++first)
    for (std::size_t k = first; k < numbers.size(); k += kApart) result.push_back(numbers[k]);
  return result;
}

constexpr std::size_t kTaps = 16;  // a whole register; the last four are 0

/// Adds z phi of each row to the bins that it reaches.
void add_rows(std::span<const std::size_t> poles, const std::size_t* first_bins, const float* phi_re,
              const float* phi_im, const float* z_re, const float* z_im, float* __restrict bins_re,
              float* __restrict bins_im) {
  for (std::size_t r = 0; r < poles.size(); ++r, phi_re += kTaps, phi_im += kTaps) {
    const float of_re = z_re[poles[r]], of_im = z_im[poles[r]];
    if (of_re == 0.0F && of_im == 0.0F) continue;
    float *re = bins_re + first_bins[r], *im = bins_im + first_bins[r];
    for (std::size_t k = 0; k < kTaps; ++k) {
      re[k] += of_re * phi_re[k] - of_im * phi_im[k];
      im[k] += of_re * phi_im[k] + of_im * phi_re[k];
    }
  }
}

void add_product(const float* a, const float* b, std::size_t n, float* __restrict out) {
  for (std::size_t k = 0; k < n; ++k) out[k] += a[k] * b[k];
}

}  // namespace

RingingTransform::RingingTransform(const std::vector<Complex>& poles) : fft_(kLength), holds_(poles.size(), false) {
  for (std::size_t p = 0; p < poles.size(); ++p) {
    const double bin = poles[p].imag() * kLength / (2.0 * std::numbers::pi);
    const double first = std::floor(bin) - kHalfWidth + 1;
    // the transform has no bins 0 and M / 2
    holds_[p] = -poles[p].real() * kLength / 2.0 <= kLargestDecay && first >= 1.0 && first + kWidth <= kBins;
    if (!holds_[p]) continue;
    poles_.push_back(p);
    first_bins_.push_back(static_cast<std::size_t>(first));
  }
  poles_ = interleaved(poles_);
  first_bins_ = interleaved(first_bins_);
  re_.assign(poles_.size() * kTaps, 0.0F);
  im_ = re_;
  for (std::size_t r = 0; r < poles_.size(); ++r) {
    const Complex s = poles[poles_[r]], nu = Complex{0.0, -1.0} * s * (kLength / (2.0 * std::numbers::pi));
    for (std::size_t k = 0; k < static_cast<std::size_t>(kWidth); ++k) {
      const std::size_t bin = first_bins_[r] + k;
      const Complex x = (static_cast<double>(bin) - nu) * (2.0 / kWidth);
      const double sign = bin % 2 == 0 ? 1.0 : -1.0;  // n = 0 in the middle of the transform
      const Complex phi = sign * exp(s * kMiddle) * bessel_i0_of_root(kBeta * kBeta * (1.0 - x * x));
      re_[r * kTaps + k] = static_cast<float>(phi.real());
      im_[r * kTaps + k] = static_cast<float>(phi.imag());
    }
  }
  for (std::size_t j = 0; j < kFrames; ++j)  // the transform's own scale is sqrt(2 / M)
    correction_.push_back(static_cast<float>(std::sqrt(0.5 * kLength) / psi(static_cast<double>(j) - kMiddle)));
}

void RingingTransform::add(const float* re, const float* im, std::span<float> out) const {
  std::array<float, kBins + kTaps> bins_re{}, bins_im{};
  add_rows(poles_, first_bins_.data(), re_.data(), im_.data(), re, im, bins_re.data(), bins_im.data());
  const std::span<const float> ringing = fft_.inverse(std::span(bins_re).first(kBins), std::span(bins_im).first(kBins));
  add_product(ringing.data() + kFrames / 2, correction_.data(), kFrames, out.data());
}

}  // namespace bouncelab::synthesis
