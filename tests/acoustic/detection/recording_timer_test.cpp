// SPDX-License-Identifier: GPL-3.0-or-later
// Times of a ball whose impacts were found in a low band.
#include "drops/drop_timer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/random.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kRate_hz = 44100.0;
constexpr int kImpacts = 20;

double time_of(int k) { return 0.3 + 0.3 * (1.0 - std::pow(0.97, k)) / 0.03; }

/// Largest standard error of a ball with these modes in white noise, found below 2 kHz.
double largest_sigma_s(const std::vector<double>& modes_hz, double noise) {
  std::vector<float> samples(static_cast<std::size_t>((time_of(kImpacts) + 0.5) * kRate_hz));
  Random random(3, RandomStream::test, 0);
  for (float& x : samples) x = static_cast<float>(noise * random.normal());
  std::vector<Candidate> candidates;
  Track track;
  for (int k = 0; k < kImpacts; ++k) {
    test::add_modal_sound(samples, kRate_hz, time_of(k), 0.2, test::equal_modes(modes_hz, 3e-3, 0.05));
    track.impacts.push_back({candidates.size(), k});
    candidates.push_back({time_of(k), 200.0, 0.4e-3, 50.0});
  }
  const audio::AudioSource whole = audio::source_in_memory(samples, kRate_hz);
  const audio::AudioSource band = decimate(whole, 11);
  const ArModel model = learn_ar_models(band, 48).noise;
  const BandOfDrops drops{band, whole, model, candidates, {track}, {}, {}};
  const TimedRecording timed = time_recording(drops, {}, 9.81, 1, "ball");
  EXPECT_GE(timed.onsets.size(), kImpacts);
  EXPECT_TRUE(timed.is_full_band);
  double largest = 0.0;
  for (const Onset& onset : timed.onsets) largest = std::max(largest, onset.sigma_t_s.value_or(INFINITY));
  return largest;
}

TEST(RecordingTimer, TimesInTheWholeSoundWhatWasFoundInALowBand) {
  EXPECT_LT(largest_sigma_s({700.0, 2500.0, 5300.0, 7700.0}, 2e-2), 4e-6);
}

}  // namespace
}  // namespace bouncelab::detection
