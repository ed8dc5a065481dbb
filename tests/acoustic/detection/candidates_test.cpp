// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/candidates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "support/modal_sound.hpp"
#include "whitening/whitening.hpp"

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

// hops of one sample, and just below the rates at which a hop is a sample longer: the shortest margins of a block
const double kRates_hz[] = {4000.0, 11990.0, 44100.0, 83990.0, 96000.0};

TEST(Candidates, AreInOrderTheSameOnAnyNumberOfThreadsWithTheEnergiesOfTheSoundAroundThem) {
  for (const double rate_hz : kRates_hz) {
    SCOPED_TRACE(rate_hz);
    const std::vector<float> x = struck(rate_hz);
    const audio::AudioSource sound = audio::source_in_memory(x, rate_hz);
    const CandidatesOfSound found = found_in(sound, 1), by_three = found_in(sound, 3);
    EXPECT_GE(found.candidates.size(), 27U);  // that many sounds
    ASSERT_EQ(by_three.candidates.size(), found.candidates.size());
    ASSERT_EQ(found.band_energies.size(), found.candidates.size());
    BandEnergyMeter meter(rate_hz);
    std::vector<float> around(static_cast<std::size_t>(2 * meter.reach() + 1));
    for (std::size_t k = 0; k < found.candidates.size(); ++k) {
      const Candidate &one = found.candidates[k], &other = by_three.candidates[k];
      EXPECT_EQ(one.t_s, other.t_s);
      EXPECT_EQ(one.amplitude, other.amplitude);
      EXPECT_EQ(one.log_likelihood_ratio, other.log_likelihood_ratio);
      EXPECT_TRUE(k == 0 || found.candidates[k - 1].t_s < one.t_s) << k;
      audio::read_padded(sound, std::llround(one.t_s * rate_hz) - meter.reach() - 1, around);
      for (const CandidatesOfSound* of : {&found, &by_three}) {
        EXPECT_EQ(of->band_energies[k].log_power, meter.measure(around).log_power);
        EXPECT_EQ(of->band_energies[k].added_share, meter.measure(around).added_share);
      }
    }
  }
}

TEST(InnovationEnergy, IsTheSumOfItsHopsInTheOrderOfTheirSamplesBitByBit) {
  const ArModel nothing_predicted{{1.0F}, 1e-4};
  const double floor = 0.01 * nothing_predicted.quiet_variance;
  for (const std::int64_t hop : {1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 24})
    for (const std::int64_t n_hops : {1, 7, 8, 9, 40}) {
      std::vector<float> x;  // values that are rounded when they are added
      for (std::int64_t k = 0; k < hop * n_hops; ++k)
        x.push_back(static_cast<float>(std::sin(0.7 * static_cast<double>(k * k))));
      const audio::AudioSource sound = audio::source_in_memory(x, 48000.0);
      const InnovationEnergy energy(sound, nothing_predicted, hop, 0, n_hops);
      double running = 0.0;
      for (std::int64_t k = 0; k < n_hops; ++k) {
        float sum = 0.0F;
        for (std::int64_t i = k * hop; i < (k + 1) * hop; ++i)
          sum += x[static_cast<std::size_t>(i)] * x[static_cast<std::size_t>(i)];
        running += static_cast<double>(sum) + floor * static_cast<double>(hop);
        ASSERT_EQ(energy.of_hops(0, k + 1), running) << "hop " << k << " of " << n_hops << " of " << hop << " samples";
      }
    }
}

}  // namespace
}  // namespace bouncelab::detection
