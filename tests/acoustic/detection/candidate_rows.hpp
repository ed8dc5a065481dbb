// SPDX-License-Identifier: GPL-3.0-or-later
// Candidates as the detector's tracking sees them, without any sound: impacts of balls and rows of other sounds. And
// integrals by quadrature, for its densities.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "candidates/candidates.hpp"
#include "tracking/hypothesis.hpp"

namespace bouncelab::test {

constexpr double kTiming_s = 5e-5;  // two samples at 40 kHz

/// As the shortest window finds a loud one in a full band.
inline detection::Candidate candidate(double t_s, double amplitude, double log_likelihood_ratio = 50.0) {
  return {t_s, amplitude, 0.4e-3, log_likelihood_ratio};
}

/// One drop; loudness in proportion to the flight before.
struct BallRow {
  double first_s = 1.0;
  double first_flight_s = 0.5;
  double eps = 0.8;
  int n_impacts = 10;
  double eps_scatter = 0.0;       // of its logarithm
  double loudness_scatter = 0.0;  // of its logarithm
};

inline std::vector<detection::Candidate> candidates_of(const BallRow& ball, Random random) {
  std::vector<detection::Candidate> row;
  double t_s = ball.first_s, flight_s = ball.first_flight_s;
  for (int k = 0; k < ball.n_impacts; ++k) {
    row.push_back(candidate(t_s, 500.0 * flight_s * std::exp(ball.loudness_scatter * random.normal())));
    t_s += flight_s;
    flight_s *= ball.eps * std::exp(ball.eps_scatter * random.normal());
  }
  return row;
}
inline std::vector<detection::Candidate> candidates_of(const BallRow& ball) {
  return candidates_of(ball, Random(1, RandomStream::test, 0));
}

inline void sort_by_time(std::vector<detection::Candidate>& candidates) {
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
}

inline std::vector<detection::Candidate> joined(std::vector<detection::Candidate> a,
                                                const std::vector<detection::Candidate>& b) {
  a.insert(a.end(), b.begin(), b.end());
  sort_by_time(a);
  return a;
}

/// The same recording begun earlier, and turned up.
inline std::vector<detection::Candidate> shifted(std::vector<detection::Candidate> candidates, double by_s,
                                                 double gain) {
  for (detection::Candidate& c : candidates) c.t_s += by_s, c.amplitude *= gain;
  return candidates;
}

/// Rising or falling by 13 dB an octave.
inline detection::BandEnergies tilted(float slope) {
  detection::BandEnergies energies;
  for (int octave = 0; octave < detection::kEnergyBands; ++octave) {
    energies.log_power[static_cast<std::size_t>(octave)] = slope * static_cast<float>(octave);
    energies.added_share[static_cast<std::size_t>(octave)] = 1.0F;
  }
  return energies;
}

/// By the midpoint rule.
template <class Function>
double integral(double from, double to, int n, const Function& f) {
  const double step = (to - from) / n;
  double sum = 0.0;
  for (int k = 0; k < n; ++k) sum += f(from + (k + 0.5) * step);
  return sum * step;
}

/// From minus to plus infinity, by x = centre + width tan u: exact to rounding for what falls like Student's t of about
/// that centre and width.
template <class Function>
double integral_over_line(double centre, double width, int n, const Function& f) {
  return integral(-0.5 * kPi, 0.5 * kPi, n, [&](double u) {
    const double cosine = std::cos(u);
    return f(centre + width * std::tan(u)) * width / (cosine * cosine);
  });
}

/// A hypothesis with one more impact, after n_missing that were not detected; absent where no ball does that, or below
/// the least log odds.
inline std::optional<detection::Hypothesis> extended(const detection::Hypothesis& h, const detection::Observation& next,
                                                     int n_missing, double same_source, bool is_counted,
                                                     double least_log_odds = -INFINITY) {
  const auto step = h.step_to(next, n_missing, same_source, is_counted, least_log_odds);
  if (!step) return {};
  std::optional<detection::Hypothesis> longer = h;
  longer->take(*step, next);
  return longer;
}

}  // namespace bouncelab::test
