// SPDX-License-Identifier: GPL-3.0-or-later
// Impacts that follow so closely that each rings into the next ones.
#include "timing/overlap_separation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/random.hpp"
#include "bouncelab/core/units.hpp"
#include "contact/pulse_spectrum.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 96e3;
constexpr std::size_t kWindow = 1024;
constexpr double kContact = 100.0;  // sample of the window at which contact begins
constexpr double kTau_1_s = 30e-6;

/// Eight modes from 3 to 24 kHz that ring for a millisecond.
std::vector<float> wave() {
  std::vector<float> x(kWindow, 0.0F);
  for (std::size_t n = 0; n < kWindow; ++n) {
    const double t = static_cast<double>(n) - kContact;
    if (t <= 0.0) continue;
    double sum = 0.0;
    for (int m = 0; m < 8; ++m) sum += std::sin((0.2 + 0.2 * m) * t) * std::exp(-t / 90.0);
    x[n] = static_cast<float>(sum * (1.0 - std::exp(-t * t / 8.0)));
  }
  return x;
}

ImpactTemplate learned() {
  audio::RealFft fourier(kWindow);
  ImpactTemplate learned;
  learned.whitener = {1.0F};
  learned.wave = MatchedFilter(fourier.forward(wave()), kWindow);
  learned.subbands = split_into_subbands(learned.wave);
  learned.n_template = kWindow;
  learned.contact_index = kContact;
  return learned;
}

/// The learned wave, of u = 1, as an impact of u has it, `start` samples into the recording.
void add(std::vector<float>& sound, const ImpactTemplate& learned, double amplitude, double u, double start) {
  audio::RealFft fourier(kWindow);
  const double begin = start - kContact;
  audio::Spectrum w = audio::phase_shifted(learned.wave.wave(), -learned.wave.omega() * (begin - std::floor(begin)));
  std::vector<float> here(w.size()), reference(w.size()), slope(w.size());
  PulseSpectrum::hertz().tabulate(kRate_hz / kWindow * kTau_1_s * u, here, slope);
  PulseSpectrum::hertz().tabulate(kRate_hz / kWindow * kTau_1_s, reference, slope);
  for (std::size_t b = 0; b < w.size(); ++b) {
    w.re[b] *= here[b] / reference[b];
    w.im[b] *= here[b] / reference[b];
  }
  const std::vector<float> placed = fourier.inverse(w);
  for (std::size_t n = 0; n < kWindow; ++n)
    sound[static_cast<std::size_t>(begin) + n] += static_cast<float>(amplitude) * placed[n];
}

struct Outcome {
  double ratio = 0.0;  // rms error over the bound of a sound that rings alone
  double pull = 0.0;
};

/// Twelve impacts, 250 samples apart, u from 1.2 to 1.7.
/// @param amplitude  over noise
Outcome time_chatter(const std::optional<ContactLaw>& law, double amplitude) {
  const ImpactTemplate wave = learned();
  constexpr int kTrials = 20;
  constexpr int kImpacts = 12;
  Outcome outcome;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    Random random(trial, RandomStream::test, 12);
    std::vector<float> sound(6000, 0.0F);
    for (float& x : sound) x = static_cast<float>(random.normal());
    std::vector<double> truth_s, u;
    std::vector<TimedTrackImpact> onsets;
    for (int k = 0; k < kImpacts; ++k) {
      const double start = 1000.0 + 250.3 * k;
      u.push_back(1.2 + 0.5 * k / kImpacts);
      add(sound, wave, amplitude, u.back(), start);
      truth_s.push_back(start / kRate_hz);
      TimedTrackImpact onset;
      onset.impact = k;
      onset.overlap = true;
      onset.timed.t_s = truth_s.back() + 0.3 / kRate_hz * random.normal();  // as the beginnings alone have it
      onset.timed.amplitude = 0.5 * amplitude;
      onsets.push_back(onset);
    }
    separate_overlaps(audio::source_in_memory(sound, kRate_hz), wave, law, u, 1.0, onsets);
    for (int k = 0; k < kImpacts; ++k) {
      // the bound of the wave as learned; a duller one is told worse
      const double bound_s = 1.0 / amplitude / std::sqrt(wave.wave.information(0, kWindow / 2)) / kRate_hz;
      const double error_s = onsets[k].timed.t_s - truth_s[k];
      outcome.ratio += std::pow(error_s / bound_s, 2) / (kTrials * kImpacts);
      outcome.pull += std::pow(error_s / onsets[k].timed.sigma_s, 2) / (kTrials * kImpacts);
    }
  }
  outcome.ratio = std::sqrt(outcome.ratio);
  outcome.pull = std::sqrt(outcome.pull);
  return outcome;
}

TEST(OverlapSeparation, ImpactsThatRingIntoEachOtherAreTimedAsIfEachWereAlone) {
  const Outcome outcome = time_chatter(ContactLaw{kTau_1_s, 0.0, kTau_1_s, true}, 30.0);
  // dulling costs a third of what the wave knows of its time, the neighbours' own freedom some more
  EXPECT_LT(outcome.ratio, 2.0);
  EXPECT_GT(outcome.pull, 0.8);
  EXPECT_LT(outcome.pull, 1.25);
}

TEST(OverlapSeparation, SlowImpactsSoundDullerWhichIsWhatLetsTheirNeighboursBeTimed) {
  // at 50 dB over noise what is wrongly taken away is louder than noise
  const Outcome knowing = time_chatter(ContactLaw{kTau_1_s, 0.0, kTau_1_s, true}, 300.0);
  const Outcome not_knowing = time_chatter(std::nullopt, 300.0);
  EXPECT_LT(knowing.ratio, 2.0);
  EXPECT_GT(not_knowing.ratio, 2.0 * knowing.ratio);
}

TEST(OverlapSeparation, ImpactsThatRingAloneStayWhereTheyAre) {
  std::vector<float> sound(4000, 0.0F);
  TimedTrackImpact onset;
  onset.timed.t_s = 0.02;
  std::vector<TimedTrackImpact> onsets = {onset};
  separate_overlaps(audio::source_in_memory(sound, kRate_hz), learned(), std::nullopt, {1.0}, 1.0, onsets);
  EXPECT_EQ(onsets[0].timed.t_s, 0.02);
}

}  // namespace
}  // namespace bouncelab::detection
