// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/contact_time.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::detection {
namespace {

/// At most kContact.most_impacts, evenly over the list, without the slowest.
std::vector<TimedImpact> thin_out(std::vector<TimedImpact> impacts) {
  double fastest_mps = 0.0;
  for (const TimedImpact& impact : impacts) fastest_mps = std::max(fastest_mps, impact.v_mps);
  std::erase_if(impacts, [&](const TimedImpact& impact) {
    return impact.v_mps < kContact.least_speed * fastest_mps || !(impact.fit.amplitude > 0.0);
  });
  if (impacts.size() <= kContact.most_impacts) return impacts;
  std::vector<TimedImpact> chosen;
  for (std::size_t k = 0; k < kContact.most_impacts; ++k)
    chosen.push_back(impacts[k * impacts.size() / kContact.most_impacts]);
  return chosen;
}

struct Band {
  std::size_t from = 0;
  std::size_t to = 0;      // bins from ... to - 1
  double energy = 0.0;     // of the template
  double noise = 0.0;      // variance in each real and imaginary part
  double own_noise = 0.0;  // part of the level of a training impact of amplitude 1 that is its own noise
};

double noise_at(const Subbands& subbands, std::size_t bin) {
  std::size_t subband = 0;
  while (subband + 1 < subbands.n() && subbands.edge[subband + 1] <= bin) ++subband;
  return subbands.noise[subband];
}

std::vector<Band> choose_bands(const ImpactTemplate& learned) {
  const std::size_t n_bins = learned.filter.spectrum().size() - 1;
  const std::size_t width = std::max(kContact.fewest_bins, n_bins / kContact.most_bands);
  std::vector<Band> all;
  for (std::size_t b = 1; b + width <= n_bins; b += width) {
    Band band{b, b + width, learned.filter.energy(b, b + width) + 1e-30, noise_at(learned.subbands, b + width / 2),
              0.0};
    band.own_noise = 2.0 * band.noise * static_cast<double>(width) / (learned.training_weight * band.energy);
    all.push_back(band);
  }
  std::vector<Band> bands;
  for (std::size_t m = 0; m < all.size(); ++m) {
    std::vector<double> around;
    for (std::size_t c = m > kContact.neighbours ? m - kContact.neighbours : 0;
         c < std::min(m + kContact.neighbours + 1, all.size()); ++c)
      around.push_back(all[c].energy);
    const std::size_t lower_middle = (around.size() - 1) / 2;
    if (all[m].energy >= order_statistic(std::move(around), lower_middle) &&
        kContact.least_template_snr * all[m].own_noise <= 1.0)
      bands.push_back(all[m]);
  }
  return bands;
}

double centre_bin(const MatchedFilter& filter, const Band& band) {
  double moment = 0.0;
  for (std::size_t k = band.from; k < band.to; ++k) moment += static_cast<double>(k) * filter.energy(k, k + 1);
  return moment / band.energy;
}

}  // namespace

BandLevels measure_levels(WhiteSound& white, const ImpactTemplate& learned, const std::vector<TimedImpact>& impacts) {
  BandLevels levels;
  const double rate_hz = white.source().rate_hz;
  const std::size_t n_window = learned.filter.n_window();
  const std::vector<Band> bands = choose_bands(learned);
  for (const Band& band : bands) {
    levels.f_hz.push_back(rate_hz / static_cast<double>(n_window) * centre_bin(learned.filter, band));
    levels.noise2.push_back(band.noise / band.energy);
  }
  const audio::RealFft fourier(n_window);
  std::vector<float> window(learned.n_template);
  for (const TimedImpact& impact : thin_out(impacts)) {
    const double position = impact.fit.t_s * rate_hz - learned.contact_index;
    const auto first = static_cast<std::int64_t>(std::floor(position));
    white.read(learned.whitener, first, window);  // zeros follow
    const audio::Spectrum in_phase =
        audio::phase_shifted(audio::product_conj(learned.filter.spectrum(), fourier.forward(window)),
                             learned.filter.omega() * (position - static_cast<double>(first)));
    const bool is_training = std::any_of(learned.training_t_s.begin(), learned.training_t_s.end(), [&](double t_s) {
      return std::abs(t_s - impact.fit.t_s) < kContact.same_impact_s;
    });
    std::vector<double> row;
    for (const Band& band : bands) {
      const double sum = std::accumulate(in_phase.re.begin() + static_cast<std::ptrdiff_t>(band.from),
                                         in_phase.re.begin() + static_cast<std::ptrdiff_t>(band.to), 0.0);
      row.push_back(sum / band.energy - (is_training ? impact.fit.amplitude * band.own_noise : 0.0));
    }
    levels.contact_scaling.push_back(pow(impact.v_mps, -0.2));
    levels.level.push_back(std::move(row));
  }
  return levels;
}

}  // namespace bouncelab::detection
