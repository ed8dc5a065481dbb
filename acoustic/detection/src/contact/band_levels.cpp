// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/band_levels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMostImpacts = 192;  // more would tell no more than the spread of timbre allows
constexpr double kSlowest = 0.125;         // of the fastest impact; below, sounds of others are louder
constexpr std::size_t kMostBands = 60;
constexpr std::size_t kLeastBins = 6;    // a band holds a mode and not a part of one
constexpr std::size_t kNeighbours = 4;   // on either side
constexpr double kWaveOverNoise = 30.0;  // energy of the wave over what noise left in it
constexpr double kSameImpact_s = 1e-3;

/// At most so many, evenly over the list, without the slowest.
std::vector<SpeedAndTime> thin(std::vector<SpeedAndTime> impacts) {
  double fastest_mps = 0.0;
  for (const SpeedAndTime& impact : impacts) fastest_mps = std::max(fastest_mps, impact.v_mps);
  std::erase_if(impacts, [&](const SpeedAndTime& impact) {
    return impact.v_mps < kSlowest * fastest_mps || !(impact.amplitude > 0.0);
  });
  if (impacts.size() <= kMostImpacts) return impacts;
  std::vector<SpeedAndTime> some;
  for (std::size_t k = 0; k < kMostImpacts; ++k) some.push_back(impacts[k * impacts.size() / kMostImpacts]);
  return some;
}

struct Band {
  std::size_t from = 0;
  std::size_t to = 0;      // bins from ... to - 1
  double energy = 0.0;     // of the wave
  double noise = 0.0;      // variance in each real and imaginary part
  double own_noise = 0.0;  // level that an impact of amplitude 1 the wave was learned from owes to its own noise
};

double noise_at(const Subbands& subbands, std::size_t bin) {
  std::size_t subband = 0;
  while (subband + 1 < subbands.n() && subbands.edge[subband + 1] <= bin) ++subband;
  return subbands.noise[subband];
}

std::vector<Band> choose_bands(const ImpactTemplate& wave) {
  const std::size_t n_bins = wave.wave.wave().size() - 1;
  const std::size_t width = std::max(kLeastBins, n_bins / kMostBands);
  std::vector<Band> all;
  for (std::size_t b = 1; b + width <= n_bins; b += width) {
    Band band{b, b + width, wave.wave.energy(b, b + width) + 1e-30, noise_at(wave.subbands, b + width / 2), 0.0};
    band.own_noise = 2.0 * band.noise * static_cast<double>(width) / (wave.training_weight * band.energy);
    all.push_back(band);
  }
  std::vector<Band> chosen;
  for (std::size_t m = 0; m < all.size(); ++m) {
    std::vector<double> around;
    for (std::size_t c = m > kNeighbours ? m - kNeighbours : 0; c < std::min(m + kNeighbours + 1, all.size()); ++c)
      around.push_back(all[c].energy);
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>((around.size() - 1) / 2);
    std::nth_element(around.begin(), middle, around.end());
    if (all[m].energy >= *middle && kWaveOverNoise * all[m].own_noise <= 1.0) chosen.push_back(all[m]);
  }
  return chosen;
}

double centre_bin(const MatchedFilter& wave, const Band& band) {
  double moment = 0.0;
  for (std::size_t k = band.from; k < band.to; ++k) moment += static_cast<double>(k) * wave.energy(k, k + 1);
  return moment / band.energy;
}

}  // namespace

BandLevels read_levels(const audio::AudioSource& sound, const ImpactTemplate& wave,
                       const std::vector<SpeedAndTime>& impacts) {
  BandLevels levels;
  const std::size_t n_window = wave.wave.n_window();
  const std::vector<Band> bands = choose_bands(wave);
  for (const Band& band : bands) {
    levels.f_hz.push_back(sound.rate_hz / static_cast<double>(n_window) * centre_bin(wave.wave, band));
    levels.noise2.push_back(band.noise / band.energy);
  }
  audio::RealFft fourier(n_window);
  for (const SpeedAndTime& impact : thin(impacts)) {
    const double position = impact.t_s * sound.rate_hz - wave.contact_index;
    const auto first = static_cast<std::int64_t>(std::floor(position));
    audio::WhiteWindow window = audio::read_white(sound, wave.whitener, first, n_window);
    std::fill(window.sound.begin() + static_cast<std::ptrdiff_t>(wave.n_template), window.sound.end(), 0.0F);
    const audio::Spectrum z = audio::product(
        audio::product_conj(wave.wave.wave(), fourier.forward(window.sound)),
        audio::phase_ramp(n_window / 2 + 1, wave.wave.omega() * (position - static_cast<double>(first))));
    const bool is_learned = std::any_of(wave.training_t_s.begin(), wave.training_t_s.end(),
                                        [&](double t_s) { return std::abs(t_s - impact.t_s) < kSameImpact_s; });
    std::vector<double> row;
    for (const Band& band : bands) {
      const double in_phase = std::accumulate(z.re.begin() + static_cast<std::ptrdiff_t>(band.from),
                                              z.re.begin() + static_cast<std::ptrdiff_t>(band.to), 0.0);
      row.push_back(in_phase / band.energy - (is_learned ? impact.amplitude * band.own_noise : 0.0));
    }
    levels.contact_scaling.push_back(std::pow(impact.v_mps, -0.2));
    levels.level.push_back(std::move(row));
  }
  return levels;
}

}  // namespace bouncelab::detection
