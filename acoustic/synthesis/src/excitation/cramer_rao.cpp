// SPDX-License-Identifier: GPL-3.0-or-later
#include "excitation/cramer_rao.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;

double largest(std::span<const double> samples, double so_far) {
  for (const double y : samples) so_far = std::max(so_far, std::abs(y));
  return so_far;
}

double largest_magnitude(std::span<float> samples) {
  for (float& y : samples) y = std::abs(y);
  return static_cast<double>(audio::largest(samples));
}

double sum_of_magnitudes(const double* re, const double* im, std::size_t n) {
  constexpr std::size_t kSums = 8;  // the compiler may not reorder a sum, we may
  std::array<double, kSums> sums{};
  std::size_t k = 0;
  for (; k + kSums <= n; k += kSums)
    for (std::size_t lane = 0; lane < kSums; ++lane)
      sums[lane] += std::sqrt(re[k + lane] * re[k + lane] + im[k + lane] * im[k + lane]);
  for (; k < n; ++k) sums[0] += std::sqrt(re[k] * re[k] + im[k] * im[k]);
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// What row p of a symmetric sum adds to those over its columns 0 ... p; half of the last.
void add_energy_row(double re, double im, const double* re_of_re, const double* re_of_im, const double* im_of_re,
                    const double* im_of_im, std::size_t p, double* __restrict of_re, double* __restrict of_im) {
  for (std::size_t q = 0; q < p; ++q) {
    of_re[q] += re * re_of_re[q] - im * im_of_re[q];
    of_im[q] += re * re_of_im[q] - im * im_of_im[q];
  }
  of_re[p] += 0.5 * (re * re_of_re[p] - im * im_of_re[p]);
  of_im[p] += 0.5 * (re * re_of_im[p] - im * im_of_im[p]);
}

}  // namespace

Whitening::Whitening(const ResonatorBank& bank, const FlickerFilter& noise_) : noise(noise_), slope_gains(bank.size()) {
  for (std::size_t p = 0; p < bank.size(); ++p) {
    const Complex s = bank.poles_per_s()[p] / bank.rate_hz();
    slope_gains.set(p, s * noise.whitening_gain(exp(s)));
  }
}

WaveMeter::WaveMeter(const ResonatorBank& bank) : bank_(bank) {
  std::vector<Complex> steps;
  for (const Complex& pole : bank.poles_per_s()) steps.push_back(exp(pole / bank.rate_hz()));
  for (const Complex& p : steps)
    for (const Complex& q : steps) {
      const Complex sum = 1.0 / (1.0 - p * q), conjugate = 1.0 / (1.0 - p * std::conj(q));
      re_of_re_.push_back(sum.real() + conjugate.real());
      re_of_im_.push_back(conjugate.imag() - sum.imag());
      im_of_re_.push_back(conjugate.imag() + sum.imag());
      im_of_im_.push_back(sum.real() - conjugate.real());
    }
}

double WaveMeter::ringing_energy(const PoleValues& d) const {
  // both sums are symmetric in p and q: those left of the diagonal count twice
  const std::size_t n = d.size();
  PoleValues sums(n);
  for (std::size_t p = 0; p < n; ++p)
    add_energy_row(d.re[p], d.im[p], re_of_re_.data() + p * n, re_of_im_.data() + p * n, im_of_re_.data() + p * n,
                   im_of_im_.data() + p * n, p, sums.re.data(), sums.im.data());
  return audio::dot(sums.re.data(), d.re.data(), n) + audio::dot(sums.im.data(), d.im.data(), n);
}

double WaveMeter::ringing_peak(PoleValues ringing, double peak) const {
  // single precision tells within this share of the sum of amplitudes, which bounds the peak, where to look
  constexpr double kSingle = 1e-6;
  std::array<float, static_cast<std::size_t>(ResonatorBank::kBlock)> block;
  std::array<double, static_cast<std::size_t>(ResonatorBank::kBlock)> exact;
  PoleValues before(ringing.size());
  for (;;) {
    const double bound = sum_of_magnitudes(ringing.re.data(), ringing.im.data(), ringing.size());
    if (bound <= peak) return peak;
    before = ringing;
    block.fill(0.0F);
    bank_.ring(ringing, 0.0, block);
    if (largest_magnitude(block) + kSingle * bound <= peak) continue;
    exact.fill(0.0);
    bank_.ring(before, 0.0, exact);
    peak = largest(exact, peak);
  }
}

double WaveMeter::peak(const ContactWave& wave) const {
  return wave.peak ? *wave.peak : ringing_peak(wave.ringing, largest(wave.samples, 0.0));
}

WaveMeasure WaveMeter::measure(const ContactWave& wave, const Whitening& whitening) const {
  std::vector<double> whitened = wave.slopes;
  whitening.noise.whiten(whitened);
  WaveMeasure result;
  for (const double slope : whitened) result.slope_energy += slope * slope;
  PoleValues slopes(bank_.size());
  for (std::size_t p = 0; p < bank_.size(); ++p) slopes.set(p, wave.ringing[p] * whitening.slope_gains[p]);
  result.slope_energy += ringing_energy(slopes);
  result.peak = peak(wave);
  return result;
}

}  // namespace bouncelab::synthesis
