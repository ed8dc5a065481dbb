// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/product_moments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kWindow = 1024;

audio::Spectrum random_spectrum(std::uint64_t seed) {
  Random random(seed, RandomStream::test, 21);
  audio::Spectrum spectrum;
  for (std::size_t k = 0; k <= kWindow / 2; ++k) {
    spectrum.re.push_back(static_cast<float>(random.normal()));
    spectrum.im.push_back(static_cast<float>(random.normal()));
  }
  return spectrum;
}

std::complex<double> bin(const audio::Spectrum& spectrum, std::size_t k) { return {spectrum.re[k], spectrum.im[k]}; }

/// Both sums of one sub-band, and what bounds their errors, term by term.
struct PlainSums {
  double in_phase = 0.0, quadrature = 0.0;
  double magnitude = 0.0;  // sum |P_k|
};

PlainSums plain_sums(const audio::Spectrum& filter, const audio::Spectrum& sound, std::size_t from, std::size_t to,
                     double shift) {
  PlainSums sums;
  for (std::size_t k = from; k < to; ++k) {
    const double omega = 2.0 * kPi * static_cast<double>(k) / static_cast<double>(kWindow);
    const std::complex<double> product = std::conj(bin(filter, k)) * bin(sound, k);
    const std::complex<double> moved = product * std::polar(1.0, omega * shift);
    sums.in_phase += moved.real();
    sums.quadrature -= omega * moved.imag();
    sums.magnitude += std::abs(product);
  }
  return sums;
}

Subbands with_edges(std::vector<std::size_t> edge) {
  Subbands subbands;
  subbands.edge = std::move(edge);
  subbands.noise.assign(subbands.edge.size() - 1, 1.0);
  subbands.jitter2.assign(subbands.edge.size() - 1, 0.0);
  return subbands;
}

void expect_plain_sums(const std::vector<std::size_t>& edge, const std::vector<double>& shifts) {
  const audio::Spectrum wave = random_spectrum(1), sound = random_spectrum(2);
  const MatchedFilter filter(wave, kWindow);
  const Subbands subbands = with_edges(edge);
  ProductMoments moments(filter, subbands, sound);
  for (const double shift : shifts) {
    const SubbandSums sums = moments.sums_at(shift);
    for (std::size_t j = 0; j < subbands.n(); ++j) {
      const PlainSums plain = plain_sums(wave, sound, edge[j], edge[j + 1], shift);
      // the series to 4e-7, the phasors to 1e-6
      EXPECT_NEAR(sums.in_phase[j], plain.in_phase, 1.4e-6 * plain.magnitude) << j << " at " << shift;
      // the series to 4e-5 of half a width of pi / 2 at most; the phasors times omega, up to pi
      EXPECT_NEAR(sums.quadrature[j], plain.quadrature, 7e-5 * plain.magnitude) << j << " at " << shift;
    }
  }
}

TEST(ProductMoments, AreThePlainSumsAboutOneShiftAndWhereTheSeriesHasToBeTakenAnew) {
  // sub-bands of all remainders to 8 bins, one of a single bin; shifts that one series serves, then far ones
  expect_plain_sums({1, 9, 20, 34, 35, 102, 170, 256, 300, 400, 512}, {-37.25, -37.1, -37.4, -36.0, 0.0, 1e-3, 311.5});
}

TEST(ProductMoments, OfASingleWideSubbandAreThePlainSums) {
  expect_plain_sums({1, 512}, {0.0, 0.1, 0.15, 0.25, -0.6, 2.0});
}

TEST(ProductMoments, ASubbandBehindTheTemplatesLastBinIsEmpty) {
  audio::Spectrum wave = random_spectrum(3);
  std::fill(wave.re.begin() + 200, wave.re.end(), 0.0F);
  std::fill(wave.im.begin() + 200, wave.im.end(), 0.0F);
  const audio::Spectrum sound = random_spectrum(4);
  const MatchedFilter filter(wave, kWindow);
  const Subbands subbands = with_edges({1, 100, 300, 512});
  const SubbandSums sums = ProductMoments(filter, subbands, sound).sums_at(3.0);
  EXPECT_NE(sums.in_phase[1], 0.0);
  EXPECT_EQ(sums.in_phase[2], 0.0);
  EXPECT_EQ(sums.quadrature[2], 0.0);
}

}  // namespace
}  // namespace bouncelab::detection
