// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/synthetic_recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "few_impacts.hpp"
#include "sensor/instrument.hpp"
#include "support/direct_fourier.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;

/// Mean frequency of the power of one impact [Hz].
double mean_frequency_hz(const SynthesisConfig& config) {
  std::vector<double> x = SyntheticRecording(impacts({0.05}), config).samples();
  x.resize(1 << 15, 0.0);
  const std::vector<Complex> spectrum = fourier(x);
  double sum = 0.0, moment = 0.0;
  for (std::size_t f = 1; f < spectrum.size() / 2; ++f) {
    sum += std::norm(spectrum[f]);
    moment += std::norm(spectrum[f]) * static_cast<double>(f);
  }
  return moment / sum * config.rate_hz / static_cast<double>(spectrum.size());
}

TEST(Synthesis, TheSoundIsAsLowAsTheBallsContactIsLong) {
  SynthesisConfig config = quiet();
  config.levels = Levels{1e-4, 1e-12, 1.0};
  const double steel_hz = mean_frequency_hz(config);
  // R = 2 cm, 2500 kg/m^3, as stiff as steel: contact of 118 us, not 28 us; the pulse's first zero at 1.6 / tau, 14 kHz
  // instead of 58 kHz, so that of the modes up to 45 kHz only the lowest third sounds
  config.ball = ball_from_text("radius=2cm,density=2500,E=200GPa,nu=0.3");
  EXPECT_NEAR(SyntheticRecording(impacts({0.05}), config).truth().front().contact_time_s, 117.5e-6, 1e-7);
  EXPECT_LT(mean_frequency_hz(config), 0.6 * steel_hz);
  EXPECT_LT(mean_frequency_hz(config), 1.6 / 118e-6);
  config.ball = ball_from_text("diameter=40mm,mass=3g");
  EXPECT_THROW(SyntheticRecording(impacts({0.05}), config), InvalidArgument);
  // 0.8 ms: the first zero at 2 kHz
  config.ball = ball_from_text("table-tennis,contact-time=0.8ms");
  EXPECT_LT(mean_frequency_hz(config), 1.6 / 0.8e-3);
}

TEST(Ground, OfAPlateHasItsMaterialAndLossFactor) {
  EXPECT_TRUE(ground_of(kSiliconCarbide).disk && ground_of(kVitreloy).disk && !ground_of(kGlass).disk);
  EXPECT_EQ(ground_of(kGlass).carrier_damping.loss_factor, 2e-3);
  const Ground concrete = ground_of(plate_from_text("concrete"));
  EXPECT_EQ(contact_material(concrete), plate_from_text("concrete"));
  EXPECT_EQ(concrete.carrier_damping.loss_factor, 6e-3);
}

TEST(Synthesis, TheSameImpactAtSixtyFourFractionsOfASampleIsTheSameWaveShiftedInPhase) {
  SynthesisConfig config = quiet();
  config.levels = Levels{1e-4, 1e-12, 1.0};
  const auto instrument = make_instrument(config);
  const auto spectrum_at = [&](double offset_samples) {
    std::vector<double> x =
        SyntheticRecording(impacts({0.05 + offset_samples / config.rate_hz}), config, instrument).samples();
    x.resize(1 << 15, 0.0);  // 0.34 s: what is left of the ringing is below 1e-8
    return fourier(x);
  };
  const std::vector<Complex> reference = spectrum_at(0.0);
  const auto n = static_cast<double>(1 << 15);
  for (int k = 1; k < 64; ++k) {
    const double offset = k / 64.0;
    const std::vector<Complex> shifted = spectrum_at(offset);
    // least squares of the residual shift: phase = -2 pi f d, weight |f X|^2
    double numerator = 0.0, denominator = 0.0, difference = 0.0, energy = 0.0;
    for (std::size_t f = 1; f < reference.size() / 2; ++f) {
      const double radians = 2.0 * kPi * static_cast<double>(f) / n;
      const Complex aligned = shifted[f] * std::polar(1.0, radians * offset);
      numerator += radians * std::imag(std::conj(aligned) * reference[f]);
      denominator += radians * radians * std::norm(reference[f]);
      difference += std::norm(aligned - reference[f]);
      energy += std::norm(reference[f]);
    }
    EXPECT_LT(std::abs(numerator / denominator), 1e-5) << "shift left, in samples, at offset " << offset;
    // what folds back past the converter's 100 dB, and the filter table's 1e-8
    EXPECT_LT(std::sqrt(difference / energy), 2e-5) << offset;
  }
}

TEST(Synthesis, BothSidesOfTheSoundAreWhereTheTruthSays) {
  SynthesisConfig config = quiet();
  const SyntheticRecording recording(impacts({0.05, 0.15}), config);
  const std::vector<double> x = recording.samples();
  for (const TrueImpact& hit : recording.truth()) {
    const auto at = static_cast<std::size_t>((hit.t_s + hit.travel_time_s) * config.rate_hz);
    // the converter's precursor is below 1% beyond six samples; two samples of a pulse starting like s^1.5 are small
    if (hit.impact == 0) {
      EXPECT_LT(rms(std::span(x).subspan(at - 100, 94)), 0.01 * hit.amplitude);
    }
    EXPECT_GT(rms(std::span(x).subspan(at, 40)), 0.05 * hit.amplitude);
    double largest = 0.0;
    for (std::size_t k = at; k < at + 4000; ++k) largest = std::max(largest, std::abs(x[k]));
    EXPECT_NEAR(largest, hit.amplitude, (hit.impact == 0 ? 1e-9 : 0.02)) << "the second rides on the first's ringing";
  }
  EXPECT_NEAR(recording.truth()[0].t_s, 0.15, 1e-15);
  EXPECT_NEAR(recording.truth()[1].t_s - recording.truth()[0].t_s, 0.10, 1e-15);
}

TEST(Synthesis, ImpactsAddUp) {
  SynthesisConfig config = quiet();
  config.levels = Levels{1e-4, 1e-12, 1.0};
  const auto instrument = make_instrument(config);
  // 0.7 ms apart: both within one head; and 40 ms
  const Impacts both = impacts({0.05, 0.0507, 0.0907});
  std::vector<double> sum(SyntheticRecording(both, config, instrument).samples().size(), 0.0);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::vector<double> one = SyntheticRecording(impacts({both.rows[k].t_s}), config, instrument).samples();
    for (std::size_t j = 0; j < std::min(one.size(), sum.size()); ++j) sum[j] += one[j];
  }
  const std::vector<double> together = SyntheticRecording(both, config, instrument).samples();
  for (std::size_t j = 0; j < 30000; ++j) ASSERT_NEAR(together[j], sum[j], 1e-9) << j;  // 1e-12 noise, 1e-11 silence
}

TEST(Synthesis, TheMomentumIsHeard) {
  // quasi-static: at equal contact time the wave is proportional to m v (1 + eps)
  SynthesisConfig config = quiet();
  config.levels = Levels{1e-4, 1e-12, 1.0};
  const auto instrument = make_instrument(config);
  Impacts soft = impacts({0.05}), hard = impacts({0.05});
  soft.rows[0].v_after_mps = 0.0;
  hard.rows[0].v_after_mps = 1.0;
  EXPECT_NEAR(SyntheticRecording(hard, config, instrument).truth()[0].amplitude /
                  SyntheticRecording(soft, config, instrument).truth()[0].amplitude,
              2.0, 1e-12);
}

TEST(Synthesis, WhatSinglePrecisionRoundsOffIsFarBelowTheNoise) {
  SynthesisConfig config = quiet();
  config.levels = Levels{3e-4, 1e-5, 1.0};  // the faintest noise with which floats do
  std::vector<double> times_s;
  for (int k = 0; k < 40; ++k) times_s.push_back(0.05 + 0.017 * k);
  const Impacts many = impacts(times_s);
  const auto instrument = make_instrument(config);
  const std::vector<double> single = SyntheticRecording(many, config, instrument).samples();
  // the same noise, faint enough for doubles
  SynthesisConfig exact = config;
  exact.levels->noise_rms = 9e-6;
  const std::vector<double> doubles = SyntheticRecording(many, exact, instrument).samples();
  exact.levels->noise_rms = 1e-14;
  const std::vector<double> sound = SyntheticRecording(many, exact, instrument).samples();
  std::vector<double> difference(single.size());
  for (std::size_t k = 0; k < single.size(); ++k)
    difference[k] = single[k] - sound[k] - (doubles[k] - sound[k]) * (1e-5 / 9e-6);
  EXPECT_GT(rms(sound), 0.02);
  // rounding to 24 bits at amplitudes of 0.1 to 1: 40 dB below the noise
  EXPECT_LT(rms(difference), 1e-2 * 1e-5);
  EXPECT_GT(rms(difference), 0.0);
}

TEST(Synthesis, AcrossASegmentsBorderTheWaveGoesOn) {
  // at 8 kHz the converter's filter responds 4 ms before an impact
  for (const int rate_hz : {8000, 96000}) {
    SynthesisConfig config = quiet();
    config.rate_hz = rate_hz;
    config.max_mode_hz = 4e3;
    config.levels = Levels{1e-4, 1e-12, 1.0};
    const std::int64_t border = SyntheticRecording(impacts({0.05}), config).segment_frames();
    const double border_s = static_cast<double>(border) / rate_hz;
    const Impacts around = impacts({border_s - 0.1 - 0.01, border_s - 0.1 - 0.0001, border_s - 0.1 + 0.0015});
    const std::vector<double> across = SyntheticRecording(around, config).samples();
    config.lead_in_s += 0.25;  // the same sound, elsewhere in its segment
    const std::vector<double> within = SyntheticRecording(around, config).samples();
    const auto shift = static_cast<std::size_t>(rate_hz / 4);
    for (auto k = static_cast<std::size_t>(border - rate_hz / 50); k < static_cast<std::size_t>(border + rate_hz / 50);
         ++k)
      ASSERT_NEAR(across[k], within[k + shift], 1e-9) << rate_hz << " Hz, " << k;
  }
}

TEST(Synthesis, AfterTheContactThereIsNothingButTheModesOfTheTable) {
  SynthesisConfig config = quiet();
  config.max_mode_hz = 4.5e3;
  Impacts off_centre = impacts({0.05});  // where no mode has a node
  off_centre.states.resize(1);
  off_centre.states[0].position_m = {0.03, 0.02, 0.003};
  config.levels = SyntheticRecording(off_centre, config).levels();
  config.levels->noise_rms = 1e-30;
  const std::vector<double> x = SyntheticRecording(off_centre, config).samples();
  const PlateModes plate(config.ground, config.max_mode_hz);
  ASSERT_GE(plate.modes().size(), 5u);
  // each factor 1 - 2 Re(E) z^-1 + |E|^2 z^-2 takes out one damped sinusoid of exactly this frequency and decay
  const auto without = [](std::vector<double> y, double decay_per_s, double radps, double rate_hz) {
    const Complex e = std::exp(Complex{-decay_per_s, radps} / rate_hz);
    for (std::size_t k = y.size(); k-- > 2;) y[k] += -2.0 * e.real() * y[k - 1] + std::norm(e) * y[k - 2];
    return y;
  };
  // from 6 ms after the impact, when the sensor's resonance has gone, until a resonator is put to rest at 1e-11; every
  // eighth sample, or modes below 4.5 kHz would hardly differ from one another
  constexpr std::size_t kStride = 8;
  std::vector<double> decimated;
  for (std::size_t k = 15000; k < 16000; k += kStride) decimated.push_back(x[k]);
  const auto left_over = [&](std::size_t spared) {
    std::vector<double> y = decimated;
    const double rate_hz = static_cast<double>(config.rate_hz) / kStride;
    for (std::size_t k = 0; k < plate.modes().size(); ++k)
      if (k != spared) y = without(y, plate.modes()[k].decay_per_s, 2.0 * kPi * plate.modes()[k].frequency_hz, rate_hz);
    y = without(y, 2.0 * kPi * config.sensor.highpass_hz, 0.0, rate_hz);  // the AC coupling
    return rms(std::span(y).subspan(20)) / rms(decimated);
  };
  EXPECT_LT(left_over(plate.modes().size()), 1e-12) << "rounding, raised by up to 4 by each of eight factors";
  for (std::size_t k = 0; k < plate.modes().size(); ++k)
    EXPECT_GT(left_over(k), 1e-7) << "mode " << k << " is not in the sound";
}

TEST(Synthesis, TheRoomsTailHasItsLevelAndDecay) {
  for (const double decay_60db_s : {0.02, 0.15, 0.6}) {
    constexpr double kWavRate_hz = 48000.0;
    const ReverberationTail tail({-15.0, decay_60db_s}, kWavRate_hz);
    std::vector<double> x(static_cast<std::size_t>(3.0 * kWavRate_hz), 0.0);
    x[0] = 1.0;
    tail.add_to(x);
    const auto energy_from = [&](double t_s) {
      double sum = 0.0;
      for (auto k = static_cast<std::size_t>(t_s * kWavRate_hz); k < x.size(); ++k) sum += k == 0 ? 0.0 : x[k] * x[k];
      return 10.0 * std::log10(sum);
    };
    EXPECT_NEAR(energy_from(0.0), -15.0, 0.05);
    if (decay_60db_s < 0.1) continue;  // shorter than the longest of its lines
    // 30 dB in half the time; the first echoes are few, so 1.5 dB
    EXPECT_NEAR(energy_from(0.05) - energy_from(0.05 + 0.5 * decay_60db_s), 30.0, 1.5);
  }
}

TEST(Synthesis, TheTimbreChangesAsTheBallWanders) {
  SynthesisConfig config = quiet();
  config.levels = Levels{1e-4, 1e-12, 1.0};
  Impacts here = impacts({0.05}), there = impacts({0.05});
  here.states.resize(1);
  there.states.resize(1);
  there.states[0].position_m = {0.02, 0.01, 0.003};
  const auto instrument = make_instrument(config);
  const SyntheticRecording a(here, config, instrument), b(there, config, instrument);
  const std::vector<double> x = a.samples(), y = b.samples();
  double xy = 0.0, xx = 0.0, yy = 0.0;
  for (std::size_t k = 0; k < std::min(x.size(), y.size()); ++k) {
    xy += x[k] * y[k];
    xx += x[k] * x[k];
    yy += y[k] * y[k];
  }
  EXPECT_LT(std::abs(xy) / std::sqrt(xx * yy), 0.9);
  EXPECT_EQ(b.truth()[0].x_m, 0.02);
  const double nearer_m = std::hypot(0.115, 0.065) - std::hypot(0.095, 0.055);
  EXPECT_NEAR(a.truth()[0].travel_time_s - b.truth()[0].travel_time_s, nearer_m / rayleigh_speed_mps(kGlass), 1e-15);
  EXPECT_NEAR(1e6 * 0.01 / rayleigh_speed_mps(kGlass), 3.25, 0.1) << "3 to 5 us per cm (docs/physics.md)";
}

TEST(Synthesis, DisturbancesAreThereAtTimesOfTheSeedAndLeaveTheTruthAlone) {
  SynthesisConfig config = quiet();
  config.snr_db = 40.0;
  config.pause_s = 3.0;
  const Impacts three = impacts({0.1, 0.3, 0.5});
  const SyntheticRecording plain(three, config);
  config.disturbances = {0.5, 50.0, 0.2, 3.0, 2.0, 1.0, 0.0, 0.0};
  const SyntheticRecording rough(three, config);
  ASSERT_EQ(rough.truth().size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(rough.truth()[k].t_s, plain.truth()[k].t_s);
  const auto n_of = [&](OtherSoundKind kind) {
    return std::count_if(rough.others().begin(), rough.others().end(), [&](const auto& o) { return o.kind == kind; });
  };
  EXPECT_GE(n_of(OtherSoundKind::knock), 3) << "every impact has its double hit";
  EXPECT_GT(n_of(OtherSoundKind::click), 0);
  EXPECT_TRUE(plain.others().empty());
  EXPECT_EQ(rough.samples(), rough.samples());
  EXPECT_GT(rms(rough.samples()), rms(plain.samples()));
  for (double Disturbances::*const one : {&Disturbances::clicks_per_s, &Disturbances::knocks_per_s,
                                          &Disturbances::double_hit_fraction, &Disturbances::speech_per_s}) {
    config.disturbances = {};
    config.disturbances.*one = 1.0;
    const auto first_s = [&](std::uint64_t seed) {
      config.seed = seed;
      return SyntheticRecording(three, config).others().at(0).t_s;
    };
    EXPECT_NE(first_s(1), first_s(2));
  }
}

TEST(Synthesis, SpeechHasItsFormantsAndIsAsLoudAsSaid) {
  SynthesisConfig config = quiet();
  config.lead_in_s = 4.0;
  config.disturbances.speech_per_s = 0.5;
  const SyntheticRecording recording(impacts({8.0}), config);
  ASSERT_GE(recording.others().size(), 2u);
  const std::vector<double> x = recording.samples();
  double strongest = 0.0;
  int n_syllables = 0;
  for (const OtherSound& syllable : recording.others()) {
    EXPECT_EQ(syllable.kind, OtherSoundKind::speech);
    const auto begin = static_cast<std::size_t>(syllable.t_s * config.rate_hz);
    if (begin + 32768 > static_cast<std::size_t>(11.9 * config.rate_hz)) continue;  // the ball
    std::vector<double> sound(x.begin() + static_cast<std::ptrdiff_t>(begin),
                              x.begin() + static_cast<std::ptrdiff_t>(begin + 32768));
    EXPECT_LT(rms(std::span(sound).first(300)), 0.02 * rms(sound)) << "it begins softly";
    for (const double y : sound) strongest = std::max(strongest, std::abs(y));
    const std::vector<Complex> spectrum = fourier(sound);
    double within = 0.0, all = 0.0;
    for (std::size_t f = 1; f < spectrum.size() / 2; ++f) {
      const double f_hz = static_cast<double>(f) * config.rate_hz / static_cast<double>(spectrum.size());
      all += std::norm(spectrum[f]);
      if (f_hz > 150.0 && f_hz < 3600.0) within += std::norm(spectrum[f]);
    }
    EXPECT_GT(within, 0.8 * all) << "formants from 300 to 3200 Hz; below, the pitch";
    ++n_syllables;
  }
  EXPECT_GE(n_syllables, 2);
  EXPECT_GT(strongest, 0.5 * recording.levels().weakest_peak);
  EXPECT_LT(strongest, 2.0 * 5.0 * recording.levels().weakest_peak) << "two may overlap";
}

TEST(Synthesis, GainControlScalesSoundAndNoiseAlike) {
  SynthesisConfig config = quiet();
  config.snr_db = 30.0;
  Impacts three = impacts({0.05, 0.35, 0.36});
  three.rows[1].v_mps = three.rows[2].v_mps = 0.6;
  three.rows[1].v_after_mps = three.rows[2].v_after_mps = 0.55;
  const SyntheticRecording plain(three, config);
  config.gain_control_db = 20.0;
  const SyntheticRecording controlled(three, config);
  const std::vector<double> x = plain.samples(), y = controlled.samples();
  const auto gain_db_at = [&](double t_s) {  // over 20 samples, which differ by the rounding of floats
    const auto at = static_cast<std::size_t>(t_s * config.rate_hz);
    return 20.0 * std::log10(rms(std::span(y).subspan(at, 20)) / rms(std::span(x).subspan(at, 20)));
  };
  const auto arrival_s = [&](std::size_t k) { return plain.truth()[k].t_s + plain.truth()[k].travel_time_s; };
  EXPECT_NEAR(gain_db_at(arrival_s(0) - 0.02), 0.0, 1e-9) << "noise before the first impact";
  EXPECT_NEAR(gain_db_at(arrival_s(0) + 1e-3), -20.0, 0.05) << "sound; 20 samples are 0.2 ms";
  EXPECT_NEAR(gain_db_at(arrival_s(0) + 0.251), -20.0 * std::exp(-0.25 / 0.3), 0.05) << "noise";
  const double weaker = plain.truth()[1].amplitude / plain.truth()[0].amplitude;
  EXPECT_GT(weaker, 1.1 * std::exp(-1.0)) << "else the first would hide the second";
  EXPECT_NEAR(gain_db_at(arrival_s(1) + 1e-3), -20.0 * weaker, 0.05);
  EXPECT_NEAR(gain_db_at(arrival_s(2) + 0.201), -20.0 * weaker * std::exp(-0.2 / 0.3), 0.05) << "a maximum, no sum";
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(controlled.truth()[k].sigma_t_s, plain.truth()[k].sigma_t_s);
}

TEST(Synthesis, WithoutTheBallAllElseSoundsAsItDid) {
  SynthesisConfig config = with_hard_case(quiet(), "rough");
  config.disturbances.timbre_wander = 0.0;
  const Impacts three = impacts({0.05, 0.35, 0.6});
  const SyntheticRecording whole(three, config);
  config.without_ball = true;
  const SyntheticRecording others(three, config);
  EXPECT_TRUE(others.truth().empty());
  ASSERT_EQ(others.others().size(), whole.others().size());
  EXPECT_EQ(others.levels().noise_rms, whole.levels().noise_rms);
  // the ball alone, with noise 180 dB further down
  SynthesisConfig alone = quiet();
  alone.pause_s = config.pause_s;
  alone.levels = whole.levels();
  alone.levels->noise_rms = 1e-12;
  const std::vector<double> x = whole.samples(), y = others.samples(),
                            ball = SyntheticRecording(three, alone).samples();
  ASSERT_EQ(y.size(), x.size());
  ASSERT_EQ(ball.size(), x.size());
  // resonators stop 80 dB below the noise
  for (std::size_t k = 0; k < x.size(); ++k) ASSERT_NEAR(x[k] - ball[k], y[k], 1e-3 * whole.levels().noise_rms) << k;
  EXPECT_GT(*std::max_element(ball.begin(), ball.end()), 5.0 * whole.levels().noise_rms);
}

TEST(Synthesis, ADeadChannelHoldsNoiseOnlyAndClippingIsFlagged) {
  SynthesisConfig config = quiet();
  config.snr_db = 40.0;
  config.peak = 2.0;
  config.channels = {Channel{0.1, 0.0, 0.0, 0.0}, Channel{}};
  const SyntheticRecording recording(impacts({0.05}), config);
  const std::vector<double> x = recording.samples();
  double largest[2] = {0.0, 0.0};
  for (std::size_t k = 0; k < x.size(); ++k) largest[k % 2] = std::max(largest[k % 2], std::abs(x[k]));
  EXPECT_LT(largest[0], 6.0 * recording.levels().noise_rms);
  EXPECT_EQ(largest[1], 1.0);
  EXPECT_TRUE(recording.truth()[0].flags.has(Flag::clipped));
}

TEST(Synthesis, EveryPresetSensorAndRateMakesASound) {
  for (const Material& plate : {kGlass, kSiliconCarbide, kVitreloy})
    for (const bool by_air : {false, true})
      for (const int rate_hz : {8000, 44100, 192000, 2000000}) {
        SynthesisConfig config = quiet();
        config.pause_s = 0.05;
        config.ground = ground_of(plate);
        config.rate_hz = rate_hz;
        if (by_air) {
          config.sensor = microphone();
          config.channels = {Channel{0.1, 0.1, 0.2, 1.0}};
        }
        const SyntheticRecording recording(impacts({0.05}), config);
        EXPECT_NEAR(recording.truth()[0].amplitude, 0.5, 1e-12);
        if (by_air) {  // in space at 343 m/s; rounding
          EXPECT_NEAR(recording.truth()[0].travel_time_s, std::hypot(0.1, 0.1, 0.2) / 343.0, 1e-17);
        }
        EXPECT_GT(rms(recording.samples()), 1e-3);
        EXPECT_EQ(recording.n_frames(), static_cast<std::int64_t>(std::ceil((0.1 + 0.05 + 0.05) * rate_hz - 1e-6)));
      }
}

}  // namespace
}  // namespace bouncelab::synthesis
