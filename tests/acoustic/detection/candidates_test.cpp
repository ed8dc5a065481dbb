// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/candidates.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "candidates/band_energies.hpp"
#include "support/modal_sound.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {
namespace {

/// Noise, and sounds every 0.15 s: some at either end and where one block of the search goes over into the next.
std::vector<float> struck(double rate_hz) {
  constexpr double kLength_s = 4.0;
  std::vector<float> x(static_cast<std::size_t>(kLength_s * rate_hz));
  std::uint32_t state = 7;
  for (float& sample : x) {
    state = 1664525U * state + 1013904223U;
    sample = static_cast<float>(1e-3 * (state / 4294967296.0 - 0.5));
  }
  const test::ModalSound ping = test::equal_modes({0.1 * rate_hz, 0.23 * rate_hz}, 5e-3, 0.05);
  for (double t_s = 0.004; t_s < kLength_s; t_s += 0.15) test::add_modal_sound(x, rate_hz, t_s, 0.1, ping);
  test::add_modal_sound(x, rate_hz, kLength_s - 0.004, 0.1, ping);
  return x;
}

CandidatesOfSound found_in(const audio::AudioSource& sound, int n_threads) {
  return find_candidates(sound, learn_ar_models(sound, 48).signal, n_threads, {});
}

void expect_equal(const CandidatesOfSound& a, const CandidatesOfSound& b) {
  ASSERT_EQ(a.candidates.size(), b.candidates.size());
  ASSERT_EQ(a.band_energies.size(), b.band_energies.size());
  for (std::size_t k = 0; k < a.candidates.size(); ++k) {
    EXPECT_EQ(a.candidates[k].t_s, b.candidates[k].t_s);
    EXPECT_EQ(a.candidates[k].amplitude, b.candidates[k].amplitude);
    EXPECT_EQ(a.candidates[k].log_likelihood_ratio, b.candidates[k].log_likelihood_ratio);
    EXPECT_EQ(a.band_energies[k].log_power, b.band_energies[k].log_power);
    EXPECT_EQ(a.band_energies[k].added_share, b.band_energies[k].added_share);
  }
}

// hops of one sample, and just below the rates at which a hop is a sample longer: the shortest margins of a block
const double kRates_hz[] = {4000.0, 11990.0, 44100.0, 83990.0, 96000.0};

TEST(Candidates, AreTheSameOnAnyNumberOfThreads) {
  for (const double rate_hz : kRates_hz) {
    SCOPED_TRACE(rate_hz);
    const std::vector<float> x = struck(rate_hz);
    const audio::AudioSource sound = audio::source_in_memory(x, rate_hz);
    const CandidatesOfSound found = found_in(sound, 1);
    EXPECT_GE(found.candidates.size(), 27U);  // that many sounds
    expect_equal(found_in(sound, 3), found);
  }
}

TEST(Candidates, HaveTheEnergiesOfTheSoundAroundThem) {
  for (const double rate_hz : kRates_hz) {
    SCOPED_TRACE(rate_hz);
    const std::vector<float> x = struck(rate_hz);
    const audio::AudioSource sound = audio::source_in_memory(x, rate_hz);
    const CandidatesOfSound found = found_in(sound, 1);
    ASSERT_EQ(found.band_energies.size(), found.candidates.size());
    BandEnergyMeter meter(rate_hz);
    std::vector<float> around(static_cast<std::size_t>(2 * meter.reach() + 1));
    for (std::size_t k = 0; k < found.candidates.size(); ++k) {
      audio::read_padded(sound, std::llround(found.candidates[k].t_s * rate_hz) - meter.reach() - 1, around);
      EXPECT_EQ(found.band_energies[k].log_power, meter.measure(around).log_power);
      EXPECT_EQ(found.band_energies[k].added_share, meter.measure(around).added_share);
    }
  }
}

TEST(Candidates, AreInTheOrderOfTheirTimes) {
  const std::vector<float> x = struck(44100.0);
  const auto found = found_in(audio::source_in_memory(x, 44100.0), 1).candidates;
  EXPECT_TRUE(
      std::is_sorted(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.t_s < b.t_s; }));
}

}  // namespace
}  // namespace bouncelab::detection
