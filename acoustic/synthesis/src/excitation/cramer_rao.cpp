// SPDX-License-Identifier: GPL-3.0-or-later
#include "excitation/cramer_rao.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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
  double total = 0.0;
  const std::size_t n = d.size();
  const double *of_re = d.re.data(), *of_im = d.im.data();
  for (std::size_t p = 0, row = 0; p < n; ++p, row += n) {
    const double re = audio::dot(re_of_re_.data() + row, of_re, n) + audio::dot(re_of_im_.data() + row, of_im, n);
    const double im = audio::dot(im_of_re_.data() + row, of_re, n) + audio::dot(im_of_im_.data() + row, of_im, n);
    total += 0.5 * (of_re[p] * re - of_im[p] * im);
  }
  return total;
}

double WaveMeter::ringing_peak(PoleValues ringing, double peak) const {
  const auto bound = [&] {
    double sum = 0.0;
    for (std::size_t p = 0; p < ringing.size(); ++p) sum += std::sqrt(std::norm(ringing[p]));
    return sum;
  };
  std::array<double, static_cast<std::size_t>(ResonatorBank::kBlock)> block{};
  while (bound() > peak) {
    block.fill(0.0);
    bank_.ring(ringing, 0.0, block);
    peak = largest(block, peak);
  }
  return peak;
}

double WaveMeter::peak(const ContactWave& wave) const { return ringing_peak(wave.ringing, largest(wave.samples, 0.0)); }

WaveMeasure WaveMeter::measure(ContactWave wave, const Whitening& whitening) const {
  whitening.noise.whiten(wave.slopes);
  WaveMeasure result;
  for (const double slope : wave.slopes) result.slope_energy += slope * slope;
  PoleValues slopes(bank_.size());
  for (std::size_t p = 0; p < bank_.size(); ++p) slopes.set(p, wave.ringing[p] * whitening.slope_gains[p]);
  result.slope_energy += ringing_energy(slopes);
  result.peak = peak(wave);
  return result;
}

}  // namespace bouncelab::synthesis
