// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/clutter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kSmallestReach_s = 2e-3;
constexpr double kPseudoCount = 1.0;  // clutter expected in a window where none is seen, in counts
constexpr double kKernelWidth = 0.5;  // of log amplitude
/// The nearest octave: that below sqrt(2) times as much.
int window_octave(double flight_s) {
  return std::clamp(std::ilogb(2.0 * std::numbers::sqrt2 / kSmallestReach_s * flight_s), 0, kChanceOctaves - 1);
}

double reach_s(int octave) { return kSmallestReach_s * static_cast<double>(1 << octave); }

/// 1 + 1/2 + ... + 1/n, between whole n as its asymptotic series; n >= 1.
double harmonic(double n) {
  const auto approximately = [](double m) { return log(m) + 0.5772 + 0.5 / m; };
  constexpr int kTabulated = 1024;
  static const std::vector<double> table = [&] {
    std::vector<double> values;
    for (int m = 0; m <= kTabulated; ++m) values.push_back(approximately(std::max(1, m)));
    return values;
  }();
  if (!(n < kTabulated)) return approximately(n);
  const auto below = static_cast<std::size_t>(n);
  return table[below] + (n - static_cast<double>(below)) * (table[below + 1] - table[below]);
}

/// The least that reaches so far.
int octave_of(double distance_s) {
  const double distance = distance_s / kSmallestReach_s;
  if (distance <= 1.0) return 0;
  int exponent = 0;  // 2^(exponent - 1) <= distance < 2^exponent
  return std::frexp(distance, &exponent) == 0.5 ? exponent - 1 : exponent;
}

/// How much j and k are rivals, 0 ... 1.
float rivals_share(const std::vector<BandEnergies>& band_energies, std::size_t j, std::size_t k) {
  return band_energies.empty()
             ? 1.0F
             : static_cast<float>(same_source_weight(same_source_probability(band_energies[j], band_energies[k])));
}

void count(const Candidate& one, const Candidate& other, int octave, float share, Rivals& rivals) {
  const double ratio = other.amplitude / one.amplitude;
  rivals.density[octave] += share * static_cast<float>(amplitude_kernel(log(ratio)));
  rivals.all += share;
  if (ratio >= 1.0) rivals.stronger += share;
}

void accumulate(Rivals& rivals) {
  for (int octave = 1; octave < kChanceOctaves; ++octave) rivals.density[octave] += rivals.density[octave - 1];
}

}  // namespace

std::vector<Rivals> count_rivals(const std::vector<Candidate>& c, const std::vector<BandEnergies>& band_energies) {
  std::vector<Rivals> rivals(c.size());
  for (std::size_t k = 0; k < c.size(); ++k) {
    count(c[k], c[k], 0, 1.0F, rivals[k]);
    for (std::size_t j = k + 1; j < c.size(); ++j) {
      const int octave = octave_of(c[j].t_s - c[k].t_s);
      if (octave >= kChanceOctaves) break;
      const float share = rivals_share(band_energies, j, k);
      count(c[k], c[j], octave, share, rivals[k]);
      count(c[j], c[k], octave, share, rivals[j]);
    }
  }
  for (Rivals& r : rivals) accumulate(r);
  return rivals;
}

Rivals count_rivals_of(std::size_t k, const std::vector<Candidate>& c, const std::vector<BandEnergies>& band_energies,
                       const std::vector<std::size_t>& not_counted) {
  Rivals rivals;
  count(c[k], c[k], 0, 1.0F, rivals);
  const auto count_if_free = [&](std::size_t j) {
    const int octave = octave_of(std::abs(c[j].t_s - c[k].t_s));
    if (octave >= kChanceOctaves) return false;
    if (!std::binary_search(not_counted.begin(), not_counted.end(), j))
      count(c[k], c[j], octave, rivals_share(band_energies, j, k), rivals);
    return true;
  };
  for (std::size_t j = k + 1; j < c.size() && count_if_free(j); ++j) {
  }
  for (std::size_t j = k; j-- > 0 && count_if_free(j);) {
  }
  accumulate(rivals);
  return rivals;
}

double rival_window_s(double flight_s) { return reach_s(window_octave(flight_s)); }

double clutter_intensity(const Rivals& rivals, double flight_s, double own) {
  const int octave = window_octave(flight_s);
  const double itself = amplitude_kernel(0.0);
  const double others = std::max(0.0, rivals.density[octave] - itself - own);
  return (kPseudoCount * itself + others) / (2.0 * reach_s(octave));
}

double amplitude_kernel(double log_ratio) { return student3(log_ratio, kKernelWidth); }

double chance_of_first(const Rivals& rivals) { return rivals.stronger * harmonic(rivals.all); }

std::vector<double> log_rise_odds(const std::vector<Candidate>& c, double n_in_window) {
  constexpr std::size_t kAround = 24;  // candidates on either side
  constexpr double kAround_s = 1.0;
  constexpr double kThreshold = 8.0;
  const double kExcess = 1.5 + 0.14 * n_in_window;  // mean LLR of fluctuations over the threshold; white noise has 1
  constexpr double kPrior = 4.0;                    // candidates that the prior share of events, one half, is worth
  constexpr double kEventsPerSample = 1.7;
  const double z0 = kEventsPerSample * n_in_window;
  std::vector<double> event, fluctuation, odds(c.size());
  for (const Candidate& candidate : c) {
    const double z = std::max(0.0, candidate.log_likelihood_ratio - kThreshold);
    event.push_back(z0 / square(z0 + z));
    fluctuation.push_back(exp(-z / kExcess) / kExcess);
  }
  for (std::size_t k = 0; k < c.size(); ++k) {
    std::size_t first = k, last = k;
    while (first > 0 && k - first < kAround && c[k].t_s - c[first - 1].t_s < kAround_s) --first;
    while (last + 1 < c.size() && last - k < kAround && c[last + 1].t_s - c[k].t_s < kAround_s) ++last;
    double share = 0.5;
    for (int round = 0; round < 3; ++round) {
      double sum = 0.5 * kPrior;
      for (std::size_t j = first; j <= last; ++j)
        if (j != k) sum += share * event[j] / (share * event[j] + (1.0 - share) * fluctuation[j]);
      share = sum / (kPrior + static_cast<double>(last - first));
    }
    odds[k] = log(event[k] / (share * event[k] + (1.0 - share) * fluctuation[k]));
  }
  return odds;
}

double student3(double x, double width) {
  const double width2 = width * width;
  const double core = width2 + x * x * (1.0 / 3.0);  // (1 + z^2 / 3) width^2
  return 2.0 / (kPi * std::numbers::sqrt3) * width2 * width / (core * core);
}

}  // namespace bouncelab::detection
