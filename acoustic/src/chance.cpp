// SPDX-License-Identifier: GPL-3.0-or-later
#include "chance.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "bouncelab/core/units.hpp"

namespace bouncelab {
namespace {

constexpr double kSmallestReach_s = 2e-3;
constexpr double kRhythmShare = 0.5;
constexpr double kRhythmScatter = 0.1;  // of log interval from one to the next, hands and feet: 3 to 8 %

/// The nearest octave: that below sqrt(2) times as much.
int window_octave(double flight_s) {
  return std::clamp(std::ilogb(2.0 * std::numbers::sqrt2 / kSmallestReach_s * flight_s), 0, kChanceOctaves - 1);
}

double reach_s(int octave) { return kSmallestReach_s * static_cast<double>(1 << octave); }

double harmonic(int n) {
  const auto approximately = [](int m) { return std::log(m) + 0.5772 + 0.5 / m; };
  constexpr int kTabulated = 1024;
  static const std::vector<double> table = [&] {
    std::vector<double> values;
    for (int m = 0; m < kTabulated; ++m) values.push_back(approximately(m));
    return values;
  }();
  return n < kTabulated ? table[static_cast<std::size_t>(n)] : approximately(n);
}

}  // namespace

std::vector<Rivals> count_rivals(const std::vector<Candidate>& c) {
  std::vector<Rivals> rivals(c.size());
  const double widest_s = reach_s(kChanceOctaves - 1);
  for (std::size_t k = 0; k < c.size(); ++k) {
    const auto count = [&](std::size_t j) {
      const double distance = std::abs(c[j].t_s - c[k].t_s) / kSmallestReach_s;
      const int octave = distance <= 1.0 ? 0 : static_cast<int>(std::ceil(std::log2(distance)));
      if (octave >= kChanceOctaves) return;
      ++rivals[k].all[octave];
      if (c[j].amplitude >= c[k].amplitude) ++rivals[k].stronger[octave];
    };
    for (std::size_t j = k; j < c.size() && c[j].t_s - c[k].t_s <= widest_s; ++j) count(j);
    for (std::size_t j = k; j-- > 0 && c[k].t_s - c[j].t_s <= widest_s;) count(j);
    for (int octave = 1; octave < kChanceOctaves; ++octave) {
      rivals[k].all[octave] += rivals[k].all[octave - 1];
      rivals[k].stronger[octave] += rivals[k].stronger[octave - 1];
    }
  }
  return rivals;
}

double rival_window_s(double flight_s) { return reach_s(window_octave(flight_s)); }

double chance_rate(const Rivals& rivals, double flight_s, int n_own) {
  const int octave = window_octave(flight_s);
  const int rank = std::max(1, rivals.stronger[octave] - n_own);
  return rank * harmonic(std::max(rank, rivals.all[octave] - n_own)) / (2.0 * reach_s(octave));
}

double chance_of_first(const Rivals& rivals) { return rivals.stronger.back() * harmonic(rivals.all.back()); }

double rhythm_density(double gap) { return kRhythmShare * student3(std::log(gap), kRhythmScatter) / gap; }

double student3(double x, double width) {
  const double width2 = width * width;
  const double core = width2 + x * x * (1.0 / 3.0);  // (1 + z^2 / 3) width^2
  return 2.0 / (kPi * std::numbers::sqrt3) * width2 * width / (core * core);
}

}  // namespace bouncelab
