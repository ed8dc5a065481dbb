// SPDX-License-Identifier: GPL-3.0-or-later
#include "excitation/resonator_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "excitation/point_response.hpp"
#include "sensor/instrument.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;
constexpr double kBankRate_hz = 96000.0;

TEST(HertzPulse, HasUnitImpulseAndStartsLikeThreeHalves) {
  const QuadratureRule rule = gauss_legendre(400, 0.0, 1.0);
  double impulse = 0.0;
  for (std::size_t k = 0; k < rule.nodes.size(); ++k) impulse += rule.weights[k] * hertz_force(rule.nodes[k]);
  EXPECT_NEAR(impulse, 1.0, 1e-8) << "energy: the speed turns round, so the force integrates to twice the momentum";
  const double half = 0.4 * std::beta(0.4, 0.5);  // contact time 2 half (delta/v) = 2.943 delta/v
  EXPECT_NEAR(2.0 * half, 2.943, 5e-4) << "Johnson's constant";
  // x = t - 5/28 t^(7/2) ... : at s = 0.01 the force is the leading power within 1e-3 (1.5 * 5/28 * 0.03^2.5 = 4e-5)
  const double leading = 1.25 * std::pow(2.0 * half * 0.01, 1.5) * half;
  EXPECT_NEAR(hertz_force(0.01) / leading, 1.0, 1e-3);
  EXPECT_DOUBLE_EQ(hertz_force(0.3), hertz_force(0.7));
  EXPECT_EQ(hertz_force(-0.1), 0.0);
}

TEST(HertzPulse, PointImpulsesStandForThePulseUpToHalfTheSampleRate) {
  const auto transform = [](const PointImpulses& points, double radians) {
    Complex sum = 0.0;
    for (std::size_t q = 0; q < points.nodes.size(); ++q)
      sum += points.weights[q] * std::polar(1.0, -radians * points.nodes[q]);
    return sum;
  };
  const PointImpulses fine = hertz_impulses(3000.0);
  for (const double duration : {0.3, 1.0, 3.0, 6.0, 12.0, 60.0, 400.0})
    for (const double frequency : {0.01, 0.2, 0.35, 0.5}) {
      const double radians = 2.0 * kPi * frequency * duration;
      EXPECT_LT(std::abs(transform(hertz_impulses(duration), radians) - transform(fine, radians)), 2e-9)
          << duration << " samples, " << frequency;
    }
}

double at(const ConverterFilter& filter, double u_samples) {
  double value = 0.0;
  filter.add(u_samples, 1.0, {&value, 1});
  return value;
}

/// Fourier transform of the converter's filter at a frequency in cycles per sample.
double converter_gain(const ConverterFilter& filter, double frequency) {
  double sum = 0.0;
  const QuadratureRule rule = gauss_legendre(8, 0.0, 0.25);
  for (double u = 0.0; u < ConverterFilter::kHalfWidth_samples; u += 0.25)
    for (std::size_t k = 0; k < rule.nodes.size(); ++k)
      sum +=
          2.0 * rule.weights[k] * at(filter, u + rule.nodes[k]) * std::cos(2.0 * kPi * frequency * (u + rule.nodes[k]));
  return sum;
}

TEST(ConverterFilter, PassesTheBandAndStopsWhatWouldFoldBack) {
  const ConverterFilter filter;
  for (double f = 0.0; f <= 0.40; f += 0.01) EXPECT_NEAR(converter_gain(filter, f), 1.0, 2e-5) << f;
  for (double f = 0.5; f < 6.0; f += 0.013) EXPECT_LT(std::abs(converter_gain(filter, f)), 1.3e-5) << f;  // 98 dB
}

/// y(t) of one resonator by brute force: the pulse convolved with the filter convolved with the ringing, on a fine
/// grid.
double brute_force(const ConverterFilter& filter, Complex pole, Complex amplitude, const Contact& contact,
                   double frame) {
  const double lo = contact.arrival_samples - ConverterFilter::kHalfWidth_samples;
  const double hi =
      std::min(frame, contact.arrival_samples + contact.duration_samples + ConverterFilter::kHalfWidth_samples);
  if (frame <= lo) return 0.0;
  const PointImpulses pulse = hertz_impulses(60.0);
  const int n_pieces = static_cast<int>(std::ceil((hi - lo) * 4.0));
  double sum = 0.0;
  for (int k = 0; k < n_pieces; ++k) {
    const double step = (hi - lo) / n_pieces;
    const QuadratureRule rule = gauss_legendre(10, lo + k * step, lo + (k + 1) * step);
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      double g = 0.0;
      for (std::size_t q = 0; q < pulse.nodes.size(); ++q)
        g += pulse.weights[q] *
             at(filter, rule.nodes[i] - contact.arrival_samples - contact.duration_samples * pulse.nodes[q]);
      sum += rule.weights[i] * contact.impulse * g *
             (amplitude * std::exp(pole / kBankRate_hz * (frame - rule.nodes[i]))).real();
    }
  }
  return sum;
}

TEST(ResonatorBank, AgreesWithBruteForceConvolution) {
  const std::vector<Complex> poles{{-150.0, 2 * kPi * 1.1e3},
                                   {-300.0, 2 * kPi * 17e3},
                                   {-400.0, 2 * kPi * 38e3},
                                   {-3e4, 2 * kPi * 60e3},
                                   {-900.0, 0.0}};
  const ResonatorBank bank(poles, kBankRate_hz);
  const ConverterFilter filter;
  const Contact contact{100.37, 3.1, 0.7};
  for (std::size_t p = 0; p < poles.size(); ++p) {
    PoleValues amplitudes(poles.size());
    amplitudes.set(p, {0.3, p + 1 == poles.size() ? 0.0 : -0.8});
    ContactWave wave = bank.wave(contact, amplitudes, true);
    EXPECT_EQ(wave.end() % ResonatorBank::kBlock, 0);
    std::vector<double> y = wave.samples;
    y.resize(y.size() + 64, 0.0);
    PoleValues ringing = wave.ringing;
    bank.ring(ringing, 0.0, std::span(y).last(64));
    double largest = 0.0;
    for (const double sample : y) largest = std::max(largest, std::abs(sample));
    for (std::size_t k = 0; k < y.size(); k += 7)  // both read the same table of the filter; the rest is below 1e-8
      EXPECT_NEAR(y[k],
                  brute_force(filter, poles[p], amplitudes[p], contact,
                              static_cast<double>(wave.first) + static_cast<double>(k)),
                  1e-8 * std::max(largest, 1e-3))
          << "pole " << p << ", sample " << k;
    for (std::size_t k = 8; k + 8 < wave.slopes.size(); k += 5) {
      // central difference over +-0.01 sample: error (omega 0.01)^2/6 of the slope, below 2e-4
      const double frame = static_cast<double>(wave.first) + static_cast<double>(k);
      const double difference = (brute_force(filter, poles[p], amplitudes[p], contact, frame + 0.01) -
                                 brute_force(filter, poles[p], amplitudes[p], contact, frame - 0.01)) /
                                0.02;
      EXPECT_NEAR(wave.slopes[k], difference, 2e-3 * largest) << "pole " << p << ", sample " << k;
    }
  }
}

TEST(ResonatorBank, AdvancingIsRinging) {
  const ResonatorBank bank({{-150.0, 2 * kPi * 1.1e3}, {-900.0, 0.0}}, kBankRate_hz);
  PoleValues rung(2), advanced(2);
  rung.set(0, {0.3, 0.4});
  rung.set(1, 0.5);
  advanced = rung;
  std::vector<double> out(640, 0.0);
  bank.ring(rung, 0.0, out);
  bank.advance(advanced, 640);
  for (std::size_t p = 0; p < 2; ++p) EXPECT_LT(std::abs(rung[p] - advanced[p]), 1e-13);
  EXPECT_NEAR(out[0], 0.8, 1e-15);
  EXPECT_NEAR(out[639],
              (Complex{0.3, 0.4} * std::exp(bank.poles_per_s()[0] * 639.0 / kBankRate_hz)).real() +
                  0.5 * std::exp(-900.0 * 639.0 / kBankRate_hz),
              1e-13);
}

TEST(WaveMeter, ClosedFormEqualsTheSumOverSamples) {
  const std::vector<Complex> poles{
      {-150.0, 2 * kPi * 1.1e3}, {-300.0, 2 * kPi * 17e3}, {-310.0, 2 * kPi * 17.2e3}, {-900.0, 0.0}};
  const ResonatorBank bank(poles, kBankRate_hz);
  PoleValues amplitudes(poles.size());
  for (std::size_t p = 0; p < poles.size(); ++p) amplitudes.set(p, {0.1 * static_cast<double>(p), p == 3 ? 0.0 : 0.5});
  const Contact contact{100.37, 3.1, 0.7};
  const WaveMeasure measure =
      WaveMeter(bank).measure(bank.wave(contact, amplitudes, true), {bank, FlickerFilter(0.0, kBankRate_hz)});

  const ContactWave wave = bank.wave(contact, amplitudes, true);
  double energy = 0.0, peak = 0.0;
  for (const double slope : wave.slopes) energy += slope * slope;
  for (const double sample : wave.samples) peak = std::max(peak, std::abs(sample));
  for (int n = 0; n < 20000; ++n) {
    double slope = 0.0, sample = 0.0;
    for (std::size_t p = 0; p < poles.size(); ++p) {
      const Complex z = wave.ringing[p] * std::exp(poles[p] / kBankRate_hz * static_cast<double>(n));
      sample += z.real();
      slope += (z * poles[p] / kBankRate_hz).real();
    }
    energy += slope * slope;
    peak = std::max(peak, std::abs(sample));
  }
  EXPECT_NEAR(measure.slope_energy / energy, 1.0, 1e-10) << "20000 samples leave exp(-60)";
  EXPECT_NEAR(measure.peak, peak, 1e-12);
}

}  // namespace
}  // namespace bouncelab::synthesis
