// SPDX-License-Identifier: GPL-3.0-or-later
#include "excitation/point_response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "sensor/converter.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;

double largest_magnitude(std::span<const double> samples, double so_far = 0.0) {
  for (const double y : samples) so_far = std::max(so_far, std::abs(y));
  return so_far;
}

double sum_of_magnitudes(const PoleValues& values) {
  const double *re = values.re.data(), *im = values.im.data();
  const std::size_t n = values.size();
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
  std::array<double, static_cast<std::size_t>(ResonatorBank::kBlock)> block;
  while (sum_of_magnitudes(ringing) > peak) {  // which bounds all that follows
    block.fill(0.0);
    bank_.ring(ringing, 0.0, block);
    peak = largest_magnitude(block, peak);
  }
  return peak;
}

double WaveMeter::peak(const ContactWave& wave) const {
  return wave.peak ? *wave.peak : ringing_peak(wave.ringing, largest_magnitude(wave.samples));
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

namespace {

constexpr int kConverterReach = ConverterFilter::kHalfWidth_samples;
/// K is zero before -kConverterReach; what the interpolation reaches before that is stored as zeros.
constexpr auto kFirst = static_cast<std::int64_t>(-kConverterReach - PointResponse::kLongestContact_samples - 6);
/// From here on the impulse rings freely.
constexpr std::int64_t kFree = kConverterReach + 1;
/// A wave goes on to the next end of a block, after the contact and the converter's reach.
constexpr auto kRow = static_cast<std::size_t>(PointResponse::kLongestContact_samples + kConverterReach +
                                               ResonatorBank::kBlock + 8 - kFirst);

/// Blocks of values after the longest wave, among which its peak is looked for.
constexpr std::size_t kLaterBlocks = 16;
constexpr std::size_t kLongRow = kRow + kLaterBlocks * static_cast<std::size_t>(ResonatorBank::kBlock);

/// Interpolates between quarters of a sample: Kaiser's windowed sinc. It passes 0.5 cycles in a sample within 1e-8, and
/// stops their images, from 3.5 on, as well.
constexpr int kHalfWidth_quarters = 8;

double windowed_sinc_of_quarters(double u) {
  constexpr double kBeta = 16.7;  // 160 dB: 0.1102 (160 - 8.7)
  const double sinc = u == 0.0 ? 1.0 : sin(kPi * u) / (kPi * u);
  return sinc * kaiser_window(u / kHalfWidth_quarters, kBeta);
}

const KernelTable& interpolation() {
  static const KernelTable table(windowed_sinc_of_quarters, kHalfWidth_quarters);
  return table;
}

/// z = z e + tap, pole by pole.
void horner_step(const double* e_re, const double* e_im, double tap, std::size_t n, double* re, double* im) {
  for (std::size_t p = 0; p < n; ++p) {
    const double before = re[p];
    re[p] = (before * e_re[p] - im[p] * e_im[p]) + tap;
    im[p] = before * e_im[p] + im[p] * e_re[p];
  }
}

/// Appends free ringing until there are at least `n`.
void continue_ringing(const ResonatorBank& bank, PoleValues state, std::size_t n, std::vector<double>& values) {
  const std::size_t n_before = values.size();
  if (n <= n_before) return;
  constexpr auto kBlock = static_cast<std::size_t>(ResonatorBank::kBlock);
  values.resize(n_before + (n - n_before + kBlock - 1) / kBlock * kBlock, 0.0);
  bank.ring(state, 0.0, std::span(values).subspan(n_before));
}

std::int64_t quotient_rounded_up(std::int64_t a, std::int64_t b) { return a >= 0 ? (a + b - 1) / b : -(-a / b); }
std::int64_t quotient_rounded_down(std::int64_t a, std::int64_t b) { return -quotient_rounded_up(-a, b); }

}  // namespace

PointResponse::PointResponse(const ResonatorBank& bank, const PoleValues& amplitudes)
    : bank_(bank), quarter_step_(bank.size()) {
  for (std::size_t p = 0; p < bank.size(); ++p)
    quarter_step_.set(p, exp(bank.poles_per_s()[p] / (kPhases * bank.rate_hz())));
  tabulate(amplitudes);
  bound_later_values();
}

void PointResponse::tabulate(const PoleValues& amplitudes) {
  for (int phase = 0; phase < kPhases; ++phase) {
    // the impulse arrives before frame 0, so that frame n is at n + phase / 4 after it
    const ContactWave wave = bank_.wave({-static_cast<double>(phase) / kPhases, 0.0, 1.0}, amplitudes, true);
    std::vector<double>&values = values_[static_cast<std::size_t>(phase)],
    &slopes = slopes_[static_cast<std::size_t>(phase)];
    values.assign(static_cast<std::size_t>(wave.first - kFirst), 0.0);
    slopes = values;
    values.insert(values.end(), wave.samples.begin(), wave.samples.end());
    slopes.insert(slopes.end(), wave.slopes.begin(), wave.slopes.end());
    continue_ringing(bank_, wave.ringing, kLongRow, values);
    PoleValues slope_ringing = wave.ringing;
    for (std::size_t p = 0; p < bank_.size(); ++p)
      slope_ringing.set(p, wave.ringing[p] * (bank_.poles_per_s()[p] / bank_.rate_hz()));
    continue_ringing(bank_, slope_ringing, kRow, slopes);
    PoleValues& free = free_[static_cast<std::size_t>(phase)];
    free = wave.ringing;
    bank_.advance(free, kFree - wave.end());
  }
}

/// After the last value by the sum of amplitudes.
void PointResponse::bound_later_values() {
  constexpr auto kBlock = static_cast<std::size_t>(ResonatorBank::kBlock);
  constexpr auto kBegin = static_cast<std::size_t>(kFree - kFirst);
  bounds_.assign(kLaterBlocks + 1, 0.0);
  for (std::size_t phase = 0; phase < values_.size(); ++phase) {
    PoleValues at_last = free_[phase];
    bank_.advance(at_last, static_cast<std::int64_t>(kLaterBlocks) * ResonatorBank::kBlock);
    bounds_.back() = std::max(bounds_.back(), sum_of_magnitudes(at_last));
    for (std::size_t k = 0; k < kLaterBlocks; ++k)
      bounds_[k] =
          std::max(bounds_[k], largest_magnitude(std::span(values_[phase]).subspan(kBegin + k * kBlock, kBlock)));
  }
  for (std::size_t k = kLaterBlocks; k-- > 0;) bounds_[k] = std::max(bounds_[k], bounds_[k + 1]);
}

/// |y(n)| <= sum_m |F(m)| max |K|: until no later block can hold more than those before.
/// @return nothing where that is after the last value of K
std::optional<double> PointResponse::peak(const Filter& filter, const ContactWave& wave) const {
  constexpr auto kBlock = static_cast<std::size_t>(ResonatorBank::kBlock);
  double sum_of_taps = 0.0, peak = largest_magnitude(wave.samples);
  for (const double tap : filter.taps) sum_of_taps += std::abs(tap);
  for (std::size_t k = 0; k <= kLaterBlocks; ++k) {
    if (sum_of_taps * bounds_[k] <= peak) return peak;
    if (k == kLaterBlocks) break;
    const std::int64_t first = wave.end() + static_cast<std::int64_t>(k * kBlock);
    peak = std::max(peak, largest_magnitude(filtered(filter, values_, first, kBlock)));
  }
  return {};
}

PointResponse::Filter PointResponse::filter_of(const Contact& contact) {
  const double begin = kPhases * contact.arrival_samples, length = kPhases * contact.duration_samples;
  Filter filter;
  filter.first = static_cast<std::int64_t>(std::ceil(begin - kHalfWidth_quarters));
  const auto last = static_cast<std::int64_t>(std::floor(begin + length + kHalfWidth_quarters));
  // a multiple of 4 taps: no remainder
  filter.taps.assign(static_cast<std::size_t>(last - filter.first + 4) / 4 * 4, 0.0);
  const PointImpulses pulse = hertz_impulses(contact.duration_samples);
  for (std::size_t q = 0; q < pulse.nodes.size(); ++q)
    interpolation().add(static_cast<double>(filter.first) - begin - length * pulse.nodes[q],
                        contact.impulse * pulse.weights[q], filter.taps);
  return filter;
}

std::vector<double> PointResponse::filtered(const Filter& filter, const Rows& rows, std::int64_t first, std::size_t n) {
  std::vector<double> out(n, 0.0);
  for (std::size_t k = 0; k < filter.taps.size(); k += 4) {
    const double* sources[4];
    for (std::size_t i = 0; i < 4; ++i) {
      // 4 n - m = 4 (n - whole) + phase
      const std::int64_t m = filter.first + static_cast<std::int64_t>(k + i);
      const std::int64_t whole = quotient_rounded_up(m, kPhases);
      const auto phase = static_cast<std::size_t>(whole * kPhases - m);
      sources[i] = rows[phase].data() + (first - whole - kFirst);
    }
    audio::add_four_scaled(out.data(), filter.taps.data() + k, sources, n);
  }
  return out;
}

/// At the first frame at which all taps ring freely, or later: `from_quarter` quarters after the filter's last tap.
PoleValues PointResponse::ringing(const Filter& filter, std::int64_t from_quarter) const {
  const std::size_t n = bank_.size();
  PoleValues sum(n);
  for (const double tap : filter.taps)
    horner_step(quarter_step_.re.data(), quarter_step_.im.data(), tap, n, sum.re.data(), sum.im.data());
  const std::int64_t later = from_quarter - kFree * kPhases;
  const PoleValues& free = free_[static_cast<std::size_t>(later % kPhases)];
  for (std::size_t p = 0; p < n; ++p) sum.set(p, sum[p] * free[p]);
  bank_.advance_in_block(sum, later / kPhases);
  return sum;
}

ContactWave PointResponse::wave(const Contact& contact, bool with_slopes) const {
  constexpr std::int64_t kBlock = ResonatorBank::kBlock;
  const Filter filter = filter_of(contact);
  const std::int64_t last = filter.first + static_cast<std::int64_t>(filter.taps.size()) - 1;
  ContactWave wave;
  wave.first = quotient_rounded_down(filter.first, kPhases) - kConverterReach;
  const std::int64_t end = quotient_rounded_up(quotient_rounded_up(last, kPhases) + kFree, kBlock) * kBlock;
  const auto n = static_cast<std::size_t>(end - wave.first);
  wave.samples = filtered(filter, values_, wave.first, n);
  if (with_slopes) wave.slopes = filtered(filter, slopes_, wave.first, n);
  wave.ringing = ringing(filter, end * kPhases - last);
  wave.peak = peak(filter, wave);
  return wave;
}

}  // namespace bouncelab::synthesis
