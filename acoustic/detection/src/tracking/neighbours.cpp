// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/student.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kSmallestReach_s = 2e-3;

/// The nearest octave: that below sqrt(2) times as much.
int window_octave(double flight_s) {
  return std::clamp(std::ilogb(2.0 * std::numbers::sqrt2 / kSmallestReach_s * flight_s), 0, kWindowOctaves - 1);
}

double reach_s(int octave) { return kSmallestReach_s * static_cast<double>(1 << octave); }

/// 1 + 1/2 + ... + 1/n, between whole n as its asymptotic series; n >= 1.
double harmonic(double n) { return log(n) + 0.5772 + 0.5 / n; }

/// The least that reaches so far.
int octave_of(double distance_s) {
  const double distance = distance_s / kSmallestReach_s;
  if (distance <= 1.0) return 0;
  int exponent = 0;  // 2^(exponent - 1) <= distance < 2^exponent
  return std::frexp(distance, &exponent) == 0.5 ? exponent - 1 : exponent;
}

/// Counts one neighbour.
/// @param density  that it contributes
void count(float density, bool is_stronger, int octave, float share, Neighbours& neighbours) {
  neighbours.density[octave] += share * density;
  neighbours.all += share;
  if (is_stronger) neighbours.stronger += share;
}

void accumulate(Neighbours& n) {
  for (int octave = 1; octave < kWindowOctaves; ++octave) n.density[octave] += n.density[octave - 1];
}

}  // namespace

std::vector<Neighbours> count_neighbours(const std::vector<Candidate>& c, const SameSource& same_source,
                                         const TrackingModel& model) {
  std::vector<double> log_amplitude;
  for (const Candidate& candidate : c) log_amplitude.push_back(log(candidate.amplitude));
  std::vector<Neighbours> neighbours(c.size());
  std::vector<float> shares;
  std::size_t last = 1;  // behind the last within reach
  for (std::size_t k = 0; k < c.size(); ++k) {
    last = std::max(last, k + 1);
    count(static_cast<float>(amplitude_kernel(0.0, model)), true, 0, 1.0F, neighbours[k]);
    while (last < c.size() && c[last].t_s - c[k].t_s <= reach_s(kWindowOctaves - 1)) ++last;
    shares.resize(last - k - 1);
    same_source.weigh(k, k + 1, shares);
    int octave = 0;
    for (std::size_t j = k + 1; j < last; ++j) {
      while (c[j].t_s - c[k].t_s > reach_s(octave)) ++octave;
      const float share = shares[j - k - 1];
      const double log_ratio = log_amplitude[j] - log_amplitude[k];
      const auto density = static_cast<float>(amplitude_kernel(log_ratio, model));  // the same either way
      count(density, log_ratio >= 0.0, octave, share, neighbours[k]);
      count(density, log_ratio <= 0.0, octave, share, neighbours[j]);
    }
  }
  for (Neighbours& n : neighbours) accumulate(n);
  return neighbours;
}

Neighbours count_neighbours_of(std::size_t k, const std::vector<Candidate>& c, const SameSource& same_source,
                               const std::vector<std::size_t>& not_counted, const TrackingModel& model) {
  std::size_t first = k, last = k;
  while (first > 0 && octave_of(c[k].t_s - c[first - 1].t_s) < kWindowOctaves) --first;
  while (last + 1 < c.size() && octave_of(c[last + 1].t_s - c[k].t_s) < kWindowOctaves) ++last;
  std::vector<float> shares(last - first + 1);
  same_source.weigh(k, first, shares);
  shares[k - first] = 1.0F;
  Neighbours neighbours;
  for (std::size_t j = first; j <= last; ++j) {
    if (j != k && std::binary_search(not_counted.begin(), not_counted.end(), j)) continue;
    const auto density = static_cast<float>(amplitude_kernel(log(c[j].amplitude / c[k].amplitude), model));
    count(density, c[j].amplitude >= c[k].amplitude, octave_of(std::abs(c[j].t_s - c[k].t_s)), shares[j - first],
          neighbours);
  }
  accumulate(neighbours);
  return neighbours;
}

double clutter_window_s(double flight_s) { return reach_s(window_octave(flight_s)); }

double clutter_intensity(const Neighbours& neighbours, double flight_s, double own, const TrackingModel& model) {
  const int octave = window_octave(flight_s);
  const double itself = amplitude_kernel(0.0, model);
  // where all others are the track's own, none is left
  const double density = std::max(0.0, neighbours.density[octave] - itself - own) + model.unseen * itself;
  return density / (2.0 * reach_s(octave));
}

double amplitude_kernel(double log_ratio, const TrackingModel& model) {
  return student3(log_ratio, model.kernel_width);
}

double log_odds_against_first(const Neighbours& neighbours) {
  return log(neighbours.stronger * harmonic(std::max(1.0F, neighbours.all)));
}

}  // namespace bouncelab::detection
