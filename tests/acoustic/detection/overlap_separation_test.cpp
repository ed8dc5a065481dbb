// SPDX-License-Identifier: GPL-3.0-or-later
// Impacts that follow so closely that each rings into the next ones.
#include "drops/drop_timer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "contact/contact_time.hpp"
#include "delay/impact_timer.hpp"
#include "support/modal_sound.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 96e3;
constexpr std::size_t kWindow = 1024;
constexpr double kContact = 100.0;  // sample of the window at which contact begins
constexpr double kTau_1_s = 30e-6;

/// Eight modes from 3 to 24 kHz that ring for a millisecond.
std::vector<float> template_waveform() {
  std::vector<float> x(kWindow, 0.0F);
  test::ModalSound sound;
  for (int m = 0; m < 8; ++m) sound.modes.push_back({(0.2 + 0.2 * m) / (2.0 * kPi), 90.0});
  sound.rise_s = std::sqrt(8.0);
  test::add_modal_sound(x, 1.0, kContact, 1.0, sound);
  return x;
}

ImpactTemplate learned() {
  audio::RealFft fourier(kWindow);
  ImpactTemplate learned;
  learned.whitener = {1.0F};
  learned.filter = MatchedFilter(fourier.forward(template_waveform()), kWindow);
  learned.subbands = split_into_subbands(learned.filter);
  learned.n_template = kWindow;
  learned.contact_index = kContact;
  return learned;
}

/// The template, of scaling 1, as an impact of another scaling has it, `start` samples into the recording.
void add(std::vector<float>& sound, const ImpactTemplate& learned, double amplitude, double scaling, double start) {
  audio::RealFft fourier(kWindow);
  const double begin = start - kContact;
  audio::Spectrum w =
      audio::phase_shifted(learned.filter.spectrum(), -learned.filter.omega() * (begin - std::floor(begin)));
  const double bin = kRate_hz / kWindow * kTau_1_s;
  for (std::size_t b = 0; b < w.size(); ++b) {
    const double x = bin * static_cast<double>(b);
    const auto ratio = static_cast<float>(pulse_spectrum(x * scaling).value / pulse_spectrum(x).value);
    w.re[b] *= ratio;
    w.im[b] *= ratio;
  }
  const std::vector<float> placed = fourier.inverse(w);
  for (std::size_t n = 0; n < kWindow; ++n)
    sound[static_cast<std::size_t>(begin) + n] += static_cast<float>(amplitude) * placed[n];
}

struct Outcome {
  double ratio = 0.0;  // rms error over the bound of a sound that rings alone
  double pull = 0.0;
};

/// Twelve impacts, 250 samples apart, v^(-1/5) from 1.2 to 1.7.
/// @param amplitude  over noise
Outcome time_chatter(const ContactLaw& law, double amplitude) {
  const ImpactTemplate impact_template = learned();
  constexpr int kTrials = 20;
  constexpr int kImpacts = 12;
  Outcome outcome;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    Random random(trial, RandomStream::test, 12);
    std::vector<float> sound(6000, 0.0F);
    for (float& x : sound) x = static_cast<float>(random.normal());
    std::vector<double> truth_s;
    std::vector<TimedImpact> impacts;
    for (int k = 0; k < kImpacts; ++k) {
      const double start = 1000.0 + 250.3 * k;
      const double scaling = 1.2 + 0.5 * k / kImpacts;
      add(sound, impact_template, amplitude, scaling, start);
      truth_s.push_back(start / kRate_hz);
      TimedImpact impact;
      impact.impact = k;
      impact.overlap = true;
      impact.v_mps = std::pow(scaling, -5.0);
      impact.fit.t_s = truth_s.back() + 0.3 / kRate_hz * random.normal();  // as timed by the beginnings alone
      impact.fit.amplitude = 0.5 * amplitude;
      impacts.push_back(impact);
    }
    const audio::AudioSource source = audio::source_in_memory(sound, kRate_hz);
    WhiteSound white(source);
    separate_overlaps(white, impact_template, law, 1.0, impacts);
    for (int k = 0; k < kImpacts; ++k) {
      // the bound of the template as it is; with fewer high frequencies the bound is larger
      const double bound_s = 1.0 / amplitude / std::sqrt(impact_template.filter.information(0, kWindow / 2)) / kRate_hz;
      const double error_s = impacts[k].fit.t_s - truth_s[k];
      outcome.ratio += std::pow(error_s / bound_s, 2) / (kTrials * kImpacts);
      outcome.pull += std::pow(error_s / impacts[k].fit.sigma_s, 2) / (kTrials * kImpacts);
    }
  }
  outcome.ratio = std::sqrt(outcome.ratio);
  outcome.pull = std::sqrt(outcome.pull);
  return outcome;
}

TEST(OverlapSeparation, ImpactsThatRingIntoEachOtherAreTimedAsIfEachWereAlone) {
  const Outcome outcome = time_chatter(ContactLaw{kTau_1_s, 0.0, true}, 30.0);
  // the longer contacts cost a third of the information on the time, the neighbours' own freedom some more
  EXPECT_LT(outcome.ratio, 2.0);
  EXPECT_GT(outcome.pull, 0.8);
  EXPECT_LT(outcome.pull, 1.25);
}

TEST(OverlapSeparation, SlowImpactsAreSubtractedWithTheirOwnContactTime) {
  // at 50 dB over noise the error of a template of the wrong contact time is louder than noise
  const Outcome with_law = time_chatter(ContactLaw{kTau_1_s, 0.0, true}, 300.0);
  const Outcome without_law = time_chatter(ContactLaw{}, 300.0);
  EXPECT_LT(with_law.ratio, 2.0);
  EXPECT_GT(without_law.ratio, 2.0 * with_law.ratio);
}

TEST(Ringing, SharesTheAmplitudeBetweenImpactsThatCannotBeToldApart) {
  const ImpactTemplate impact_template = learned();
  std::vector<float> x(4000, 0.0F);
  add(x, impact_template, 0.7, 1.0, 1500.25);
  const audio::AudioSource sound = audio::source_in_memory(x, kRate_hz);
  for (const double apart_s : {0.0, 1e-10, 1e-8}) {
    WhiteSound white(sound);
    Ringing ringing(white, impact_template);
    ringing.add(1500.25 / kRate_hz, 0.3);
    ringing.add(1500.25 / kRate_hz + apart_s, 0.3);
    ringing.fit_amplitudes({true, true});
    EXPECT_NEAR(ringing.amplitude(0) + ringing.amplitude(1), 0.7, 1e-2) << apart_s;
    EXPECT_NEAR(ringing.amplitude(0), ringing.amplitude(1), 0.35) << apart_s;
  }
}

}  // namespace
}  // namespace bouncelab::detection
