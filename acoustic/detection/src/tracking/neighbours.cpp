// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/neighbours.hpp"

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"

namespace bouncelab::detection {
namespace {

/// The nearest octave: that below sqrt(2) times as much.
int window_octave(double flight_s) {
  return std::clamp(binary_exponent(2.0 * std::numbers::sqrt2 / kSmallestReach_s * flight_s), 0, kWindowOctaves - 1);
}

constexpr double reach_s(int octave) { return kSmallestReach_s * static_cast<double>(1 << octave); }

/// 1 + 1/2 + ... + 1/n, between whole n as its asymptotic series; n >= 1.
double harmonic(double n) { return log(n) + 0.5772 + 0.5 / n; }

/// Counts one neighbour.
/// @param density  that it contributes
void count(float density, bool is_stronger, int octave, float share, Neighbours& neighbours) {
  neighbours.density[octave] += share * density;
  neighbours.all += share;
  neighbours.stronger += is_stronger ? share : 0.0F;  // a branch would be mispredicted half of the time
}

/// Densities that the sounds of these log amplitudes contribute at one.
void density_row(const double* log_amplitude, double centre, double width, float* __restrict density, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) density[j] = static_cast<float>(student3(log_amplitude[j] - centre, width));
}

/// As many as fill registers of 512 bits: what is left over of a row takes as long as several of them.
constexpr std::size_t whole_registers(std::size_t n) {
  constexpr std::size_t kFloats = 16;
  return (n + kFloats - 1) / kFloats * kFloats;
}

void accumulate(Neighbours& n) {
  for (int octave = 1; octave < kWindowOctaves; ++octave) n.density[octave] += n.density[octave - 1];
}

}  // namespace

std::vector<Neighbours> count_neighbours(const std::vector<Candidate>& c, std::span<const double> log_amplitude,
                                         const SameSource& same_source) {
  std::vector<Neighbours> neighbours(c.size());
  std::vector<float> shares, densities;
  std::size_t last = 1;  // behind the last within reach
  for (std::size_t k = 0; k < c.size(); ++k) {
    last = std::max(last, k + 1);
    count(static_cast<float>(amplitude_kernel(0.0)), true, 0, 1.0F, neighbours[k]);
    while (last < c.size() && c[last].t_s - c[k].t_s <= kLargestReach_s) ++last;
    const std::size_t n = std::min(whole_registers(last - k - 1), c.size() - k - 1);
    shares.resize(n);
    same_source.weigh(k, k + 1, shares);
    densities.resize(n);
    density_row(log_amplitude.data() + k + 1, log_amplitude[k], kTracking.kernel_width, densities.data(),
                densities.size());
    int octave = 0;
    for (std::size_t j = k + 1; j < last; ++j) {
      while (c[j].t_s - c[k].t_s > reach_s(octave)) ++octave;
      const float share = shares[j - k - 1];
      const double log_ratio = log_amplitude[j] - log_amplitude[k];
      const float density = densities[j - k - 1];  // the same either way
      count(density, log_ratio >= 0.0, octave, share, neighbours[k]);
      count(density, log_ratio <= 0.0, octave, share, neighbours[j]);
    }
  }
  for (Neighbours& n : neighbours) accumulate(n);
  return neighbours;
}

Neighbours count_neighbours_of(std::size_t k, const std::vector<Candidate>& c, std::span<const double> log_amplitude,
                               const SameSource& same_source, const std::vector<std::size_t>& not_counted) {
  std::size_t first = k, end = k + 1;
  while (first > 0 && c[k].t_s - c[first - 1].t_s <= kLargestReach_s) --first;
  while (end < c.size() && c[end].t_s - c[k].t_s <= kLargestReach_s) ++end;
  const std::size_t n = std::min(whole_registers(end - first), c.size() - first);
  std::vector<float> both(2 * n);
  const std::span<float> shares(both.data(), n), densities(both.data() + n, n);
  same_source.weigh(k, first, shares);
  for (auto j = std::lower_bound(not_counted.begin(), not_counted.end(), first); j != not_counted.end() && *j < end;
       ++j)
    shares[*j - first] = 0.0F;
  shares[k - first] = 1.0F;
  density_row(log_amplitude.data() + first, log_amplitude[k], kTracking.kernel_width, densities.data(), n);
  Neighbours neighbours;
  // one octave after the other, whose sums stay in registers: from the furthest before to the furthest after
  std::size_t j = first;
  const auto count_while = [&](int octave, auto is_in_octave) {
    float density = neighbours.density[octave], all = neighbours.all, stronger = neighbours.stronger;
    for (; j < end && is_in_octave(j); ++j) {
      const float share = shares[j - first];
      density += share * densities[j - first];
      all += share;
      stronger += log_amplitude[j] >= log_amplitude[k] ? share : 0.0F;  // a branch would be mispredicted
    }
    neighbours.density[octave] = density;
    neighbours.all = all;
    neighbours.stronger = stronger;
  };
  for (int inner = kWindowOctaves - 2; inner >= 0; --inner)
    count_while(inner + 1, [&](std::size_t i) { return i < k && c[k].t_s - c[i].t_s > reach_s(inner); });
  for (int octave = 0; octave < kWindowOctaves; ++octave)
    count_while(octave, [&](std::size_t i) { return i <= k || c[i].t_s - c[k].t_s <= reach_s(octave); });
  accumulate(neighbours);
  return neighbours;
}

double clutter_window_s(double flight_s) { return reach_s(window_octave(flight_s)); }

double clutter_intensity(const Neighbours& neighbours, double flight_s, double own) {
  const int octave = window_octave(flight_s);
  const double itself = amplitude_kernel(0.0);
  // where all others are the track's own, none is left
  const double density = std::max(0.0, neighbours.density[octave] - itself - own) + kTracking.unseen * itself;
  return density / (2.0 * reach_s(octave));
}

double clutter_intensity(const Neighbours& neighbours, double flight_s) {
  const int octave = window_octave(flight_s);
  const double itself = amplitude_kernel(0.0), prior = kTracking.unseen * itself;
  const auto others = [&](int o) { return std::max(0.0, neighbours.density[o] - itself); };
  const double around_s = neighbours.around_s;
  const double around = (others(kWindowOctaves - 1) + prior) / around_s;
  return (others(octave) + prior) / (std::min(2.0 * reach_s(octave), around_s) + prior / around);
}

double least_clutter_intensity(double flight_s) {
  return kTracking.unseen * amplitude_kernel(0.0) / (2.0 * clutter_window_s(flight_s));
}

double log_odds_against_first(const Neighbours& neighbours) {
  return log(neighbours.stronger * harmonic(std::max(1.0F, neighbours.all)));
}

}  // namespace bouncelab::detection
