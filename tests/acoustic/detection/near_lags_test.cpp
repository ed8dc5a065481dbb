// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/near_lags.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bouncelab/core/random.hpp"

namespace bouncelab::detection {
namespace {

/// n_bins of noise; the first is 0, as RealFft leaves it.
audio::Spectrum noise_spectrum(std::size_t n_bins, std::uint64_t seed) {
  Random random(seed, RandomStream::test, 22);
  audio::Spectrum spectrum{{0.0F}, {0.0F}};
  while (spectrum.size() < n_bins) {
    spectrum.re.push_back(static_cast<float>(random.normal()));
    spectrum.im.push_back(static_cast<float>(random.normal()));
  }
  return spectrum;
}

float largest_magnitude(const std::vector<float>& x) {
  float largest = 0.0F;
  for (const float value : x) largest = std::max(largest, std::abs(value));
  return largest;
}

std::vector<float> near_lags(std::size_t n, const audio::Spectrum& a, const audio::Spectrum& b, std::size_t n_bins,
                             std::int64_t from, std::int64_t to) {
  std::vector<float> x;
  NearLags::of_length(n).append_inverse_of_product_conj(a, b, n_bins, from, to, x);
  return x;
}

TEST(NearLags, AreThoseOfTheWholeInverse) {
  for (const std::size_t n : {64U, 128U, 2048U, 4096U}) {
    const std::int64_t reach = NearLags::reach(n);
    // all bins that a step of half a sample leaves, all remainders to 4, and few
    for (const std::size_t n_bins : {n / 4 + 1, n / 4, n / 4 - 1, n / 4 - 2, std::size_t{5}}) {
      const audio::Spectrum a = noise_spectrum(n_bins, n), b = noise_spectrum(n_bins, n + 1);
      const std::vector<float> whole = audio::RealFft(n).inverse(audio::product_conj(a, b));
      const std::vector<float> near = near_lags(n, a, b, n_bins, -reach, reach);
      ASSERT_EQ(std::ssize(near), 2 * reach + 1);
      for (std::int64_t m = -reach; m <= reach; ++m)
        // 1.5e-5 by the weights, 1e-6 by single precision
        EXPECT_NEAR(near[static_cast<std::size_t>(m + reach)],
                    whole[static_cast<std::size_t>(m >= 0 ? m : m + static_cast<std::int64_t>(n))],
                    1.6e-5F * largest_magnitude(whole))
            << n << ' ' << n_bins << ' ' << m;
    }
  }
}

TEST(NearLags, OfASignalThatIsLoudFarAwayAreSmall) {
  // what is added from N / 4, N / 2 and 3 N / 4 later is where the window is small
  constexpr std::size_t kLength = 2048;
  const std::int64_t reach = NearLags::reach(kLength);
  for (const std::size_t far : {kLength / 4, kLength / 4 + 100, kLength / 2, 3 * kLength / 4 - 128}) {
    std::vector<float> x(kLength, 0.0F);
    x[far] = 1.0F;
    x[far + 1] = -1.0F;
    audio::Spectrum b = audio::RealFft(kLength).forward(x);
    const audio::Spectrum ones{std::vector<float>(b.size(), 1.0F), std::vector<float>(b.size(), 0.0F)};
    b.re.resize(kLength / 4);
    b.im.resize(kLength / 4);
    const std::vector<float> whole = audio::RealFft(kLength).inverse(audio::product_conj(ones, b));
    const std::vector<float> near = near_lags(kLength, ones, b, kLength / 4, -reach, reach);
    for (std::int64_t m = -reach; m <= reach; ++m)
      EXPECT_NEAR(near[static_cast<std::size_t>(m + reach)],
                  whole[static_cast<std::size_t>(m >= 0 ? m : m + static_cast<std::int64_t>(kLength))],
                  1.6e-5F * largest_magnitude(whole))
          << far << ' ' << m;
  }
}

TEST(NearLags, OfAPartOfTheLagsAreTheSameBits) {
  constexpr std::size_t kLength = 2048;
  const audio::Spectrum a = noise_spectrum(500, 1), b = noise_spectrum(513, 2);
  const std::int64_t reach = NearLags::reach(kLength);
  const std::vector<float> all = near_lags(kLength, a, b, 500, -reach, reach);
  for (const auto& [from, to] :
       {std::pair<std::int64_t, std::int64_t>{-20, 31}, {-7, -7}, {-30, -3}, {0, 0}, {5, 90}}) {
    const std::vector<float> part = near_lags(kLength, a, b, 500, from, to);
    EXPECT_TRUE(std::equal(part.begin(), part.end(), all.begin() + (from + reach))) << from << " to " << to;
    EXPECT_EQ(std::ssize(part), to - from + 1);
  }
}

}  // namespace
}  // namespace bouncelab::detection
