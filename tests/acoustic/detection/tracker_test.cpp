// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bouncelab/core/random.hpp"

namespace bouncelab::detection {
namespace {

/// A ping-pong ball as recorded by a phone with gain control: the first two impacts are turned down to a quarter, and
/// other sounds, some as loud, come before.
std::vector<Candidate> turned_down_at_first(std::uint64_t seed, std::vector<double>& impacts_s) {
  Random random(seed, RandomStream::test, 0);
  std::vector<Candidate> candidates;
  const auto add = [&](double t_s, double amplitude) { candidates.push_back({t_s, amplitude, 0.4e-3, 50.0}); };
  for (int k = 0; k < 5; ++k) add(1.8 * random.uniform(), 60.0 * random.uniform());
  double flight_s = 0.19;
  double t_s = 2.1;
  for (int k = 0; k < 30; ++k) {
    impacts_s.push_back(t_s);
    add(t_s, 1000.0 * flight_s * std::exp(0.2 * random.normal()) * (k < 2 ? 0.25 : 1.0));
    t_s += flight_s *= 0.945 * std::exp(0.004 * random.normal());
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  return candidates;
}

TEST(Tracker, BeginWithTheFirstImpactThoughItIsFaint) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<double> impacts_s;
    const std::vector<Candidate> candidates = turned_down_at_first(seed, impacts_s);
    const std::vector<Track> trains = find_tracks(candidates, 5e-5);
    ASSERT_EQ(trains.size(), 1u) << seed;
    EXPECT_EQ(candidates[trains[0].impacts.front().candidate].t_s, impacts_s.front()) << seed;
    EXPECT_EQ(trains[0].impacts.size(), impacts_s.size()) << seed;
    for (std::size_t k = 0; k < trains[0].impacts.size(); ++k)
      EXPECT_EQ(trains[0].impacts[k].impact, static_cast<std::int64_t>(k)) << seed;
  }
}

/// A drop from 0.4 s on each of whose impacts has an echo.
struct EchoingDrop {
  int n_impacts;
  double first_flight_s, eps, eps_rise, eps_scatter;  // the rise from impact to impact
  double echo_s, echo;                                // after the impact, of its amplitude
};

std::vector<Candidate> with_echoes(const EchoingDrop& d, Random random) {
  std::vector<Candidate> candidates;
  double flight_s = d.first_flight_s;
  double t_s = 0.4;
  for (int k = 0; k < d.n_impacts; ++k) {
    const double amplitude = 500.0 * flight_s * std::exp(0.25 * random.normal());
    candidates.push_back({t_s, amplitude, 0.4e-3, 50.0});
    candidates.push_back({t_s + d.echo_s, d.echo * amplitude * std::exp(0.3 * random.normal()), 0.4e-3, 20.0});
    t_s += flight_s;
    flight_s *= (d.eps + d.eps_rise * k) * std::exp(d.eps_scatter * random.normal());
  }
  return candidates;
}

TEST(Tracker, BeginWithTheFirstImpactAndNotWithItsEcho) {
  // eps grows as the ball slows down, so that the interval from the echo on fits the mean of all as well
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const EchoingDrop drop{30, 0.55, 0.905, 0.035 / 29.0, 0.003, 9e-3, 0.5};
    const std::vector<Candidate> candidates = with_echoes(drop, Random(seed, RandomStream::test, 1));
    const std::vector<Track> trains = find_tracks(candidates, 5e-5);
    ASSERT_EQ(trains.size(), 1u) << seed;
    EXPECT_EQ(trains[0].impacts.front().candidate, 0u) << seed;
  }
}

TEST(Tracker, OfFewImpactsBeginWithTheFirstAndNotWithItsEcho) {
  int n_begun = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const EchoingDrop drop{6, 0.6, 0.68, 0.008, 0.01, 12e-3, 0.6};
    const std::vector<Candidate> candidates = with_echoes(drop, Random(seed, RandomStream::test, 3));
    const std::vector<Track> trains = find_tracks(candidates, 5e-5);
    n_begun += trains.size() == 1 && trains[0].impacts.front().candidate == 0 ? 1 : 0;
  }
  EXPECT_GE(n_begun, 36);  // 26 where an echo is as good a first impact as its source
}

TEST(Tracker, KnowABallFromItsOtherDrop) {
  // a drop of eight impacts, then one of four among other sounds and with an echo each
  int n_found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed, RandomStream::test, 2);
    std::vector<Candidate> candidates;
    double t_s = 0.4;
    double last_first_s = 0.0;
    for (const int n_impacts : {8, 4}) {
      double flight_s = 0.6;
      last_first_s = t_s;
      for (int k = 0; k < n_impacts; ++k) {
        const double amplitude = 500.0 * flight_s * std::exp(0.4 * random.normal());
        candidates.push_back({t_s, amplitude, 0.4e-3, 50.0});
        candidates.push_back({t_s + 9e-3, 0.6 * amplitude, 0.4e-3, 20.0});
        t_s += flight_s;
        flight_s *= 0.75 * std::exp(0.01 * random.normal());
      }
      t_s += 1.0;
    }
    for (int k = 0; k < 3; ++k)
      candidates.push_back({random.uniform(last_first_s, t_s - 1.0), 150.0 * random.uniform(), 0.4e-3, 50.0});
    std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
    const std::vector<Track> trains = find_tracks(candidates, 5e-5);
    n_found += trains.size() == 2 && candidates[trains[1].impacts.front().candidate].t_s == last_first_s ? 1 : 0;
  }
  // one in three hides behind the others; a recording whose drops do not know of each other finds one in forty
  EXPECT_GE(n_found, 20);
}

TEST(Tracker, BeginWithNothingToWhichNoEnergyWasAdded) {
  std::vector<Candidate> candidates;
  double t_s = 0.4;
  double flight_s = 0.6;
  for (int k = 0; k < 9; ++k) {
    candidates.push_back({t_s, k < 2 ? 0.0 : 500.0 * flight_s, 0.4e-3, 50.0});
    t_s += flight_s;
    flight_s *= 0.75;
  }
  const std::vector<Track> trains = find_tracks(candidates, 5e-5);
  ASSERT_EQ(trains.size(), 1u);
  EXPECT_EQ(trains[0].impacts.front().candidate, 2u);
  EXPECT_TRUE(std::isfinite(trains[0].log_odds));
}

}  // namespace
}  // namespace bouncelab::detection
