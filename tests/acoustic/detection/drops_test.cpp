// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/drop_timer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "contact/contact_time.hpp"
#include "delay/impact_timer.hpp"
#include "support/bouncing_sound.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

// Impacts that follow so closely that each rings into the next ones.

constexpr double kRate_hz = 96e3;
constexpr std::size_t kWindow = 1024;
constexpr double kContact = 100.0;  // sample of the window at which contact begins

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

/// The template, `start` samples into the recording.
void add(std::vector<float>& sound, const ImpactTemplate& learned, double amplitude, double start) {
  audio::RealFft fourier(kWindow);
  const double begin = start - kContact;
  const std::vector<float> placed = fourier.inverse(
      audio::phase_shifted(learned.filter.spectrum(), -learned.filter.omega() * (begin - std::floor(begin))));
  for (std::size_t n = 0; n < kWindow; ++n)
    sound[static_cast<std::size_t>(begin) + n] += static_cast<float>(amplitude) * placed[n];
}

struct Outcome {
  double ratio = 0.0;  // rms error over the bound of a sound that rings alone
  double pull = 0.0;
};

/// Twelve impacts, 250 samples apart.
/// @param amplitude  over noise
Outcome time_chatter(double amplitude) {
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
      add(sound, impact_template, amplitude, start);
      truth_s.push_back(start / kRate_hz);
      TimedImpact impact;
      impact.impact = k;
      impact.overlap = true;
      impact.fit.t_s = truth_s.back() + 0.3 / kRate_hz * random.normal();  // as timed by the beginnings alone
      impact.fit.amplitude = 0.5 * amplitude;
      impacts.push_back(impact);
    }
    const audio::AudioSource source = audio::source_in_memory(sound, kRate_hz);
    WhiteSound white(source);
    separate_overlaps(white, impact_template, impacts);
    for (int k = 0; k < kImpacts; ++k) {
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
  const Outcome outcome = time_chatter(30.0);
  // the neighbours' own freedom costs some information on the time
  EXPECT_LT(outcome.ratio, 2.0);
  EXPECT_GT(outcome.pull, 0.8);
  EXPECT_LT(outcome.pull, 1.25);
}

TEST(Ringing, SharesTheAmplitudeBetweenImpactsThatCannotBeToldApart) {
  const ImpactTemplate impact_template = learned();
  std::vector<float> x(4000, 0.0F);
  add(x, impact_template, 0.7, 1500.25);
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

test::BouncingSound ball(double amplitude) {
  test::BouncingSound b;
  b.amplitude = amplitude;
  b.n_impacts = 30;
  return b;
}

std::size_t n_clipped(const test::BouncingSound& b, const std::vector<float>& x) {
  const audio::AudioSource sound = audio::source_in_memory(x, b.rate_hz);
  const std::vector<double> impacts_s = test::impact_times(b);
  const ClippingLimits limits = find_clipping_limits(sound, impacts_s);
  return static_cast<std::size_t>(
      std::ranges::count_if(impacts_s, [&](double t_s) { return limits.are_reached(sound, t_s); }));
}

std::vector<float> limited(std::vector<float> x, float lowest, float highest) {
  for (float& value : x) value = std::clamp(value, lowest, highest);
  return x;
}

std::vector<float> rounded(std::vector<float> x, float step) {
  for (float& value : x) value = step * std::round(value / step);
  return x;
}

TEST(Clipping, IsOfTheImpactsBeyondTheLimitAndOfNoOthers) {
  const test::BouncingSound b = ball(1.0);
  const std::vector<float> whole = render(b);
  const float loudest = std::ranges::max(whole), softest = std::ranges::min(whole);
  // an amplifier's limit, below full scale and on one side alone; a converter's
  for (const bool is_above : {true, false}) {
    const float lowest = is_above ? -2.0F : 0.5F * softest, highest = is_above ? 0.5F * loudest : 2.0F;
    const auto times = test::impact_times(b);
    const auto n_beyond = static_cast<std::size_t>(std::ranges::count_if(times, [&](double t_s) {
      const auto first = whole.begin() + std::llround(t_s * b.rate_hz) - 1;
      return std::any_of(first, first + 240, [&](float value) { return value <= lowest || value >= highest; });
    }));
    ASSERT_GT(n_beyond, 2U);
    EXPECT_EQ(n_clipped(b, limited(whole, lowest, highest)), n_beyond);
  }
}

TEST(Clipping, IsNoneWhereNothingIsLimited) {
  for (const float step : {0x1p-15F, 0x1p-11F}) {
    const test::BouncingSound b = ball(0.3);
    EXPECT_EQ(n_clipped(b, rounded(render(b), step)), 0U);
  }
  // three equal samples at the crest of a slow wave, the largest of the file: at 60 Hz the crest is flat to one step of
  // 16 bit for 30 samples
  test::BouncingSound b = ball(0.0);
  std::vector<float> slow(render(b).size(), 0.0F);
  double amplitude = 0.2;
  for (const double t_s : test::impact_times(b)) {
    const auto first = static_cast<std::size_t>(std::ceil(t_s * b.rate_hz));
    for (std::size_t k = 0; k < 4800 && first + k < slow.size(); ++k) {
      const double after_s = static_cast<double>(k) / b.rate_hz;
      slow[first + k] +=
          static_cast<float>(amplitude * std::exp(-after_s / 0.05) * std::sin(2.0 * std::numbers::pi * 60.0 * after_s));
    }
    amplitude *= 0.975;
  }
  EXPECT_EQ(n_clipped(b, rounded(slow, 0x1p-15F)), 0U);
}

TEST(Clipping, OfOneImpactAloneIsNotKnown) {
  const test::BouncingSound b = ball(1.0);
  const std::vector<float> whole = render(b);
  EXPECT_EQ(n_clipped(b, limited(whole, -2.0F, 0.995F * std::ranges::max(whole))), 0U);
}

// One drop as two bands of a sound show it.

constexpr double kLater_s = 0.4e-3;  // of the other band's times
constexpr int kImpacts = 24;

double time_of(int k) { return 0.3 + 0.2 * (1.0 - std::pow(0.95, k)) / 0.05; }

/// Impacts first ... last - 1, numbered from 0.
TimedDrop drop_of(int first, int last, double later_s, double correlation) {
  TimedDrop drop;
  drop.correlation = correlation;
  for (int k = first; k < last; ++k) {
    TimedImpact impact;
    impact.impact = k - first;
    impact.fit.t_s = time_of(k) + later_s;
    impact.fit.sigma_s = 5e-6;
    impact.fit.amplitude = 1.0;
    drop.impacts.push_back(impact);
  }
  return drop;
}

void expect_all(const TimedDrop& drop) {
  ASSERT_EQ(std::ssize(drop.impacts), kImpacts);
  for (int k = 0; k < kImpacts; ++k) {
    EXPECT_EQ(drop.impacts[k].impact, k);
    // the delay between the bands is exact here: what is left are roundings of a second
    EXPECT_NEAR(drop.impacts[k].fit.t_s, time_of(k), 1e-12);
  }
}

TEST(OtherBands, AddTheBeginningTheEndAndWhatIsMissingBetween) {
  TimedDrop drop = drop_of(2, 18, 0.0, 0.9);
  drop.impacts.erase(drop.impacts.begin() + 7, drop.impacts.begin() + 9);
  EXPECT_EQ(add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, INFINITY, drop), 10u);
  expect_all(drop);
}

TEST(OtherBands, AddNothingBeyondTheNextDrop) {
  TimedDrop drop = drop_of(0, 18, 0.0, 0.9);
  add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, time_of(20) - 1e-3, drop);
  EXPECT_LT(drop.impacts.back().fit.t_s, time_of(20) - 1e-3);
  EXPECT_GT(drop.impacts.size(), 18u);
}

TEST(OtherBands, AddNothingBetweenImpactsThatFollowEachOther) {
  TimedDrop drop = drop_of(0, kImpacts, 0.0, 0.9);
  TimedDrop other = drop_of(0, kImpacts, kLater_s, 0.9);
  TimedImpact echo = other.impacts[5];
  echo.fit.t_s += 20e-3;
  other.impacts.insert(other.impacts.begin() + 6, echo);
  for (std::size_t k = 6; k < other.impacts.size(); ++k) ++other.impacts[k].impact;
  EXPECT_EQ(add_impacts_of_other_band(other, -INFINITY, INFINITY, drop), 0u);
  // nor of another drop
  drop = drop_of(0, 12, 0.0, 0.9);
  EXPECT_EQ(add_impacts_of_other_band(drop_of(0, kImpacts, 55e-3, 0.9), -INFINITY, INFINITY, drop), 0u);
}

TEST(OtherBands, AddWhatIsInferredOnlyWhereTheirTemplateIsTheReliableOne) {
  TimedDrop other = drop_of(0, kImpacts, kLater_s, 0.9);
  for (std::size_t k = 18; k < other.impacts.size(); ++k) other.impacts[k].inferred = true;
  TimedDrop reliable = drop_of(0, 18, 0.0, 0.9);
  EXPECT_EQ(add_impacts_of_other_band(other, -INFINITY, INFINITY, reliable), 0u);
  TimedDrop unreliable = drop_of(0, 18, 0.0, 0.3);
  EXPECT_EQ(add_impacts_of_other_band(other, -INFINITY, INFINITY, unreliable), 6u);
  expect_all(unreliable);
}

TEST(OtherBands, StateTheErrorOfTheirDelay) {
  TimedDrop drop = drop_of(0, 18, 0.0, 0.9);
  for (std::size_t k = 0; k < drop.impacts.size(); ++k)
    drop.impacts[k].fit.t_s += 60e-6 * (static_cast<double>(k % 3) - 1.0);
  add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, INFINITY, drop);
  ASSERT_EQ(std::ssize(drop.impacts), kImpacts);
  // the median of nine differences of -60, 0 and 60 us has an error of a third of their scatter
  EXPECT_GT(drop.impacts.back().fit.sigma_s, 20e-6);
  EXPECT_NEAR(drop.impacts.back().fit.t_s, time_of(kImpacts - 1), 1e-12);
}

TEST(OtherBands, PutAnImpactWhereTheirErrorIsHalfAsLarge) {
  TimedDrop drop = drop_of(0, kImpacts, 0.0, 0.9);
  const auto misplace = [&](std::size_t k, double error_s) {
    drop.impacts[k].fit.t_s += error_s;
    drop.impacts[k].doubt_s = std::abs(error_s);
  };
  misplace(12, 5e-3);
  misplace(kImpacts - 1, -8e-3);
  EXPECT_EQ(add_impacts_of_other_band(drop_of(0, kImpacts, kLater_s, 0.9), -INFINITY, INFINITY, drop), 2U);
  expect_all(drop);
}

// Times of a ball whose impacts were found in a low band.

constexpr double kSound_hz = 44100.0;
constexpr int kDropped = 20;

double time_of_dropped(int k) { return 0.3 + 0.3 * (1.0 - std::pow(0.97, k)) / 0.03; }

/// Largest standard error of a ball with these modes in white noise, found below 2 kHz.
double largest_sigma_s(const std::vector<double>& modes_hz, double noise) {
  std::vector<float> samples(static_cast<std::size_t>((time_of_dropped(kDropped) + 0.5) * kSound_hz));
  Random random(3, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(noise * random.normal());
  std::vector<Candidate> candidates;
  Track track;
  for (int k = 0; k < kDropped; ++k) {
    test::add_modal_sound(samples, kSound_hz, time_of_dropped(k), 0.2, test::equal_modes(modes_hz, 3e-3, 0.05));
    track.impacts.push_back({candidates.size(), k});
    candidates.push_back({time_of_dropped(k), 200.0, 0.4e-3, 50.0});
  }
  const audio::AudioSource whole = audio::source_in_memory(samples, kSound_hz);
  const audio::AudioSource band = decimate(whole, 11);
  const ArModel model = learn_ar_models(band, 48).noise;
  const BandOfDrops drops{band, whole, model, candidates, {track}, {}, {}};
  const TimedRecording timed = time_recording(drops, {}, 9.81, 1, "ball");
  EXPECT_GE(timed.onsets.size(), kDropped);
  EXPECT_TRUE(timed.is_full_band);
  double largest = 0.0;
  for (const Onset& onset : timed.onsets) largest = std::max(largest, onset.sigma_t_s.value_or(INFINITY));
  return largest;
}

TEST(RecordingTimer, TimesInTheWholeSoundWhatWasFoundInALowBand) {
  EXPECT_LT(largest_sigma_s({700.0, 2500.0, 5300.0, 7700.0}, 2e-2), 4e-6);
}

TEST(RecordingTimer, TakesTheTimesOfTheBandInWhichImpactsAreAlike) {
  // above 3 kHz each impact is another noise, which begins before it as a codec's does
  std::vector<float> samples(static_cast<std::size_t>((time_of_dropped(kDropped) + 0.5) * kSound_hz));
  Random random(3, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(1e-3 * random.normal());
  std::vector<Candidate> early, late;
  Track track;
  for (int k = 0; k < kDropped; ++k) {
    const double t_s = time_of_dropped(k), before_s = 1e-3 * (k % 4);
    test::add_modal_sound(samples, kSound_hz, t_s, 0.2, test::equal_modes({500.0, 900.0, 1300.0}, 8e-3, 0.05));
    float last = 0.0F;
    const auto first = static_cast<std::size_t>((t_s - before_s) * kSound_hz);
    for (std::size_t n = first; n < first + 400; ++n) {
      const auto noise = static_cast<float>(0.1 * random.normal());
      samples[n] += noise - last;
      last = noise;
    }
    track.impacts.push_back({early.size(), k});
    early.push_back({t_s - before_s, 200.0, 1e-3, 50.0});
    late.push_back({t_s, 200.0, 1.7e-3, 50.0});
  }
  const audio::AudioSource whole = audio::source_in_memory(samples, kSound_hz);
  const audio::AudioSource low = decimate(whole, 11);
  const auto noise_of = [](const audio::AudioSource& sound) { return learn_ar_models(sound, 48).noise; };
  const BandOfDrops found{whole, {}, noise_of(whole), early, {track}, {}, {}};
  const BandOfDrops other{low, whole, noise_of(low), late, {track}, {}, {}};
  const TimedRecording timed = time_recording(found, {other}, 9.81, 1, "ball");
  ASSERT_GE(timed.onsets.size(), kDropped);
  std::vector<double> error_s;
  for (int k = 0; k < kDropped; ++k) error_s.push_back(timed.onsets[k].t_s - time_of_dropped(k));
  const auto [least, most] = std::ranges::minmax(error_s);
  EXPECT_LT(most - least, 0.1e-3);
}

}  // namespace

}  // namespace bouncelab::detection
