// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/innovation_energy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {
namespace {

/// Values that are rounded when they are added.
std::vector<float> sound_of(std::int64_t n) {
  std::vector<float> x;
  for (std::int64_t k = 0; k < n; ++k) x.push_back(static_cast<float>(std::sin(0.7 * static_cast<double>(k * k))));
  return x;
}

const ArModel kNothingPredicted{{1.0F}, 1e-4};
const double kFloor = 0.01 * kNothingPredicted.quiet_variance;

TEST(InnovationEnergy, IsTheSumOfItsHopsInTheOrderOfTheirSamplesBitByBit) {
  for (const std::int64_t hop : {1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 24})
    for (const std::int64_t n_hops : {1, 7, 8, 9, 40}) {
      const std::vector<float> x = sound_of(hop * n_hops);
      const audio::AudioSource sound = audio::source_in_memory(x, 48000.0);
      const InnovationEnergy energy(sound, kNothingPredicted, hop, 0, n_hops);
      double running = 0.0;
      for (std::int64_t k = 0; k < n_hops; ++k) {
        float sum = 0.0F;
        for (std::int64_t i = k * hop; i < (k + 1) * hop; ++i)
          sum += x[static_cast<std::size_t>(i)] * x[static_cast<std::size_t>(i)];
        running += static_cast<double>(sum) + kFloor * static_cast<double>(hop);
        ASSERT_EQ(energy.of_hops(0, k + 1), running) << "hop " << k << " of " << n_hops << " of " << hop << " samples";
      }
    }
}

TEST(InnovationEnergy, HasTheSoundOfEachBlockWithItsMarginsAndNothingOutsideTheRecording) {
  constexpr std::int64_t kHop = 6, kMargin = 20, kBlock = 100;
  constexpr std::int64_t kSamples = 5 * kHop * kBlock / 2;  // ends within a block
  const std::vector<float> x = sound_of(kSamples);
  const ArModel model{{1.0F, -0.5F, 0.25F}, 1e-4};
  const audio::AudioSource sound = audio::source_in_memory(x, 48000.0);
  for (std::int64_t first = 0; first < 3 * kBlock; first += kBlock) {
    const InnovationEnergy energy(sound, model, kHop, first - kMargin, kBlock + 2 * kMargin);
    const std::int64_t begin = kHop * (first - kMargin);
    const std::span<const float> held = energy.sound(begin, kHop * (kBlock + 2 * kMargin));
    for (std::int64_t k = 0; k < std::ssize(held); ++k) {
      const std::int64_t at = begin + k;
      const float expected = at < 0 || at >= kSamples ? 0.0F : x[static_cast<std::size_t>(at)];
      ASSERT_EQ(held[static_cast<std::size_t>(k)], expected) << "sample " << at;
    }
  }
}

}  // namespace
}  // namespace bouncelab::detection
