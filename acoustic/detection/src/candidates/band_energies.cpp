// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/band_energies.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "bouncelab/audio/dsp/real_fft.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kWindow_s = 11.6e-3;
constexpr double kLowest_hz = 90.0;
constexpr float kDetectable = 0.3F;   // least addition to a power that could be detected, of that power
constexpr float kSameScatter = 0.9F;  // of ln power in an octave: the place struck varies
constexpr float kOtherScatter = 2.5F;
constexpr float kMinLogOddsOfBand = -2.5F;
constexpr float kIndependence = 0.5F;  // factor on the log odds, since octaves are correlated
constexpr float kMaxLogOdds = 4.0F;

/// Octave of each bin; -1 = below all.
std::vector<int> octaves(std::size_t n_bins, double bin_hz) {
  std::vector<int> octave;
  for (std::size_t k = 0; k < n_bins; ++k)
    octave.push_back(static_cast<double>(k) * bin_hz < kLowest_hz
                         ? -1
                         : std::min(kEnergyBands - 1, std::ilogb(static_cast<double>(k) * bin_hz / kLowest_hz)));
  return octave;
}

using Four = float __attribute__((vector_size(16)));  // a register of every x86-64 processor
constexpr int kFours = kEnergyBands / 4;
static_assert(kEnergyBands % 4 == 0);

Four four(const std::array<float, kEnergyBands>& x, int k) {
  Four octaves;
  std::memcpy(&octaves, x.data() + 4 * k, sizeof octaves);
  return octaves;
}

float sum_of(Four x) { return (x[0] + x[2]) + (x[1] + x[3]); }

Four larger(Four x, Four y) { return x > y ? x : y; }

/// Between -kMaxLogOdds and kMaxLogOdds. Four octaves at once: dense music has a million pairs a minute.
float log_odds_of_same_source(const BandEnergies& a, const BandEnergies& b) {
  constexpr float kCurvature = 0.5F / (kSameScatter * kSameScatter) - 0.5F / (kOtherScatter * kOtherScatter);
  static const auto log_ratio = static_cast<float>(log(kOtherScatter / kSameScatter));
  Four weights{}, weighted{};
  for (int k = 0; k < kFours; ++k) {
    const Four both = four(a.added_share, k) * four(b.added_share, k);
    weights += both;
    weighted += both * (four(b.log_power, k) - four(a.log_power, k));
  }
  const float loudness = sum_of(weighted) / (1e-6F + sum_of(weights));  // of b over a
  Four log_odds{};
  for (int k = 0; k < kFours; ++k) {
    const Four share_a = four(a.added_share, k);
    const Four share_b = four(b.added_share, k);
    const Four both = share_a * share_b;
    const Four difference = four(b.log_power, k) - four(a.log_power, k) - loudness;
    // an octave in which one adds nothing counts too, by the added share of the louder one
    const Four share_of_louder = difference > 0.0F ? share_b : (difference < 0.0F ? share_a : both);
    log_odds += larger(both, share_of_louder) *
                larger(Four{} + kMinLogOddsOfBand, log_ratio - kCurvature * difference * difference);
  }
  const float sum = sum_of(log_odds) - log_ratio;  // one degree of freedom for the loudness
  return std::clamp(kIndependence * sum, -kMaxLogOdds, kMaxLogOdds);
}

/// @param log_odds  < 0
float weight_of(float log_odds) { return 2.0F / (1.0F + static_cast<float>(exp(-log_odds))); }

}  // namespace

std::vector<BandEnergies> measure_band_energies(const audio::AudioSource& sound,
                                                const std::vector<Candidate>& candidates) {
  const std::size_t n = std::max<std::size_t>(16, std::bit_ceil(static_cast<std::size_t>(kWindow_s * sound.rate_hz)));
  audio::RealFft fourier(n);
  const std::vector<int> octave = octaves(n / 2, sound.rate_hz / static_cast<double>(n));
  std::vector<float> window;
  for (std::size_t k = 0; k < n; ++k)
    window.push_back(static_cast<float>(0.5 + 0.5 * cos(kPi * static_cast<double>(k) / static_cast<double>(n))));
  std::vector<float> x(2 * n + 1);
  std::vector<float> part(n);
  const auto powers = [&] {
    std::array<float, kEnergyBands> power{};
    const audio::Spectrum spectrum = fourier.forward(part);
    for (std::size_t k = 0; k < octave.size(); ++k)
      if (octave[k] >= 0) power[octave[k]] += spectrum.re[k] * spectrum.re[k] + spectrum.im[k] * spectrum.im[k];
    return power;
  };
  std::vector<BandEnergies> band_energies(candidates.size());
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    audio::read_padded(sound, std::llround(candidates[c].t_s * sound.rate_hz) - static_cast<std::int64_t>(n) - 1, x);
    for (std::size_t k = 0; k < n; ++k) part[k] = window[k] * (x[n + k + 1] - x[n + k]);
    const auto after = powers();
    for (std::size_t k = 0; k < n; ++k) part[k] = window[k] * (x[n - k] - x[n - k - 1]);
    const auto before = powers();
    for (int b = 0; b < kEnergyBands; ++b) {
      const float added = std::max(0.0F, after[b] - before[b]);
      band_energies[c].log_power[b] = static_cast<float>(log(std::max(added, kDetectable * before[b]) + 1e-20F));
      band_energies[c].added_share[b] = added / (after[b] + before[b] + 1e-20F);
    }
  }
  return band_energies;
}

float same_source_probability(const BandEnergies& a, const BandEnergies& b) {
  return 1.0F / (1.0F + static_cast<float>(exp(-log_odds_of_same_source(a, b))));
}

float same_source_weight(const BandEnergies& a, const BandEnergies& b) {
  const float log_odds = log_odds_of_same_source(a, b);
  if (log_odds >= 0.0F) return 1.0F;
  static const float least = weight_of(-kMaxLogOdds);
  return log_odds > -kMaxLogOdds ? weight_of(log_odds) : least;
}

}  // namespace bouncelab::detection
