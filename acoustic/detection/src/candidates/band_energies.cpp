// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/candidates.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

std::size_t window_length(double rate_hz) {
  return std::max<std::size_t>(16, std::bit_ceil(static_cast<std::size_t>(kCandidates.band_window_s * rate_hz)));
}

/// The first bin of each octave, and the one behind the last.
std::array<std::size_t, kEnergyBands + 1> octave_begins(std::size_t n_bins, double bin_hz) {
  std::array<std::size_t, kEnergyBands + 1> begin;
  begin.fill(n_bins);
  for (std::size_t k = n_bins; k-- > 0;) {
    const double over_lowest = static_cast<double>(k) * bin_hz / kCandidates.lowest_band_hz;
    if (over_lowest < 1.0) break;
    const auto octave = static_cast<std::size_t>(std::min(kEnergyBands - 1, std::ilogb(over_lowest)));
    std::fill(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(octave) + 1, k);
  }
  return begin;
}

float power(const audio::Spectrum& spectrum, std::size_t k) {
  return spectrum.re[k] * spectrum.re[k] + spectrum.im[k] * spectrum.im[k];
}

// values, so that nothing branches
[[gnu::always_inline]] inline float larger(float x, float y) { return x > y ? x : y; }
[[gnu::always_inline]] inline float smaller(float x, float y) { return x < y ? x : y; }

/// Between -kCandidates.most_log_odds and kCandidates.most_log_odds.
/// @param power_of, share_of  log_power and added_share of b in an octave
template <class PowerOf, class ShareOf>
[[gnu::always_inline]] inline float log_odds_of_same_source(const BandEnergies& a, const PowerOf& power_of,
                                                            const ShareOf& share_of, float log_ratio) {
  const float curvature = 0.5F / (kCandidates.same_scatter * kCandidates.same_scatter) -
                          0.5F / (kCandidates.other_scatter * kCandidates.other_scatter);
  float weight = 1e-6F;
  float loudness = 0.0F;  // of b over a
  for (int k = 0; k < kEnergyBands; ++k) {
    const float both = a.added_share[k] * share_of(k);
    weight += both;
    loudness += both * (power_of(k) - a.log_power[k]);
  }
  loudness /= weight;
  float sum = -log_ratio;  // one degree of freedom for the loudness
  for (int k = 0; k < kEnergyBands; ++k) {
    const float power_b = power_of(k), share_a = a.added_share[k], share_b = share_of(k);
    const float both = share_a * share_b;
    const float difference = power_b - a.log_power[k] - loudness;
    // an octave in which one adds nothing counts too, by the added share of the louder one
    float share = both;
    share = difference > 0.0F ? share_b : share;
    share = difference < 0.0F ? share_a : share;
    const float of_octave = log_ratio - curvature * difference * difference;
    sum += larger(both, share) * larger(of_octave, kCandidates.least_log_odds_of_band);
  }
  return smaller(larger(kCandidates.independence * sum, -kCandidates.most_log_odds), kCandidates.most_log_odds);
}

float log_ratio_of_scatters() {
  static const auto log_ratio = static_cast<float>(log(kCandidates.other_scatter / kCandidates.same_scatter));
  return log_ratio;
}

/// To 4e-7 of it, by operations that go side by side.
/// @param x  0 ... kCandidates.most_log_odds
[[gnu::always_inline]] inline float exp_of_log_odds(float x) {
  constexpr float kExp2 = 7.389056F;
  const float z = 0.125F * x - 0.25F;  // -0.25 ... 0.25, and exp(x) = exp(2) exp(z)^8
  const float series =
      1.0F + z * (1.0F + z * (1.0F / 2 + z * (1.0F / 6 + z * (1.0F / 24 + z * (1.0F / 120 + z * (1.0F / 720))))));
  const float second = series * series;
  const float fourth = second * second;
  return kExp2 * (fourth * fourth);
}

/// @param power, share  of octave 0 of b; those of octave k lie k n_all further on
void weigh_row(const BandEnergies& first, const float* __restrict power, const float* __restrict share,
               std::size_t n_all, float log_ratio, float* __restrict weights, std::size_t n) {
  const BandEnergies a = first;
  for (std::size_t j = 0; j < n; ++j) {
    const float log_odds = log_odds_of_same_source(
        a, [&](int k) { return power[static_cast<std::size_t>(k) * n_all + j]; },
        [&](int k) { return share[static_cast<std::size_t>(k) * n_all + j]; }, log_ratio);
    weights[j] = smaller(1.0F, 2.0F / (1.0F + exp_of_log_odds(larger(-log_odds, 0.0F))));
  }
}

}  // namespace

BandEnergyMeter::BandEnergyMeter(double rate_hz)
    : fourier_(window_length(rate_hz)),
      begin_(octave_begins(fourier_.size() / 2, rate_hz / static_cast<double>(fourier_.size()))) {
  const std::size_t n = fourier_.size();
  for (std::size_t k = 0; k < n; ++k)
    window_.push_back(static_cast<float>(0.5 + 0.5 * cos(kPi * static_cast<double>(k) / static_cast<double>(n))));
}

BandEnergies BandEnergyMeter::measure(std::span<const float> sound) const {
  const std::size_t n = window_.size();
  assert(sound.size() == 2 * n + 1);
  const float* x = sound.data();
  std::vector<float> part(n);
  for (std::size_t k = 0; k < n; ++k) part[k] = window_[k] * (x[n + k + 1] - x[n + k]);
  const audio::Spectrum of_after = fourier_.forward(part);
  for (std::size_t k = 0; k < n; ++k) part[k] = window_[k] * (x[n - k] - x[n - k - 1]);
  const audio::Spectrum of_before = fourier_.forward(part);
  std::array<float, kEnergyBands> after{}, before{};
  for (int b = 0; b < kEnergyBands; ++b)
    for (std::size_t k = begin_[b]; k < begin_[b + 1]; ++k) {
      after[b] += power(of_after, k);
      before[b] += power(of_before, k);
    }
  BandEnergies energies;
  for (int b = 0; b < kEnergyBands; ++b) {
    const float added = std::max(0.0F, after[b] - before[b]);
    energies.log_power[b] = static_cast<float>(log(std::max(added, kCandidates.detectable * before[b]) + 1e-20F));
    energies.added_share[b] = added / (after[b] + before[b] + 1e-20F);
  }
  return energies;
}

SameSource::SameSource(const std::vector<BandEnergies>& band_energies) : n_sounds_(band_energies.size()) {
  const std::size_t n = n_sounds_;
  power_.resize(kEnergyBands * n);
  share_.resize(kEnergyBands * n);
  for (std::size_t k = 0; k < kEnergyBands; ++k)
    for (std::size_t j = 0; j < n; ++j) {
      power_[k * n + j] = band_energies[j].log_power[k];
      share_[k * n + j] = band_energies[j].added_share[k];
    }
}

BandEnergies SameSource::operator[](std::size_t k) const {
  BandEnergies energies;
  for (std::size_t octave = 0; octave < kEnergyBands; ++octave) {
    energies.log_power[octave] = power_[octave * n_sounds_ + k];
    energies.added_share[octave] = share_[octave * n_sounds_ + k];
  }
  return energies;
}

void SameSource::weigh(std::size_t k, std::size_t first, std::span<float> weights) const {
  if (n_sounds_ == 0) return std::fill(weights.begin(), weights.end(), 1.0F);
  weigh_row((*this)[k], power_.data() + first, share_.data() + first, n_sounds_, log_ratio_of_scatters(),
            weights.data(), weights.size());
}

float SameSource::weight(std::size_t j, std::size_t k) const {
  float weight = 1.0F;
  weigh(k, j, {&weight, 1});
  return weight;
}

SameSource SameSource::of(const std::vector<std::size_t>& sounds) const {
  if (n_sounds_ == 0) return {};
  std::vector<BandEnergies> energies;
  for (const std::size_t k : sounds) energies.push_back((*this)[k]);
  return SameSource(energies);
}

float SameSource::probability(std::size_t j, std::size_t k) const {
  if (n_sounds_ == 0) return 0.5F;
  const BandEnergies a = (*this)[j], b = (*this)[k];
  const float log_odds = log_odds_of_same_source(
      a, [&](int o) { return b.log_power[o]; }, [&](int o) { return b.added_share[o]; }, log_ratio_of_scatters());
  return 1.0F / (1.0F + static_cast<float>(exp(-log_odds)));
}

}  // namespace bouncelab::detection
