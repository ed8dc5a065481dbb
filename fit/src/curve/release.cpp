// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/release.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::fit {

std::vector<FirstFlights> first_flights(const RestitutionSamples& samples) {
  constexpr double kNearlyOne = 0.01;
  std::map<double, FirstFlights> by_speed;
  for (const RestitutionSample& s : samples) {
    if (s.impact != 1 || s.conditions.of_heights) continue;
    FirstFlights& flights = by_speed[std::round(log(s.v_mps) / kNearlyOne)];
    if (flights.samples.empty()) flights.v_mps = s.v_mps, flights.eps = s.eps;
    flights.samples.push_back(s);
  }
  std::vector<FirstFlights> all;
  for (auto& [at, flights] : by_speed) all.push_back(std::move(flights));
  return all;
}

double speed_of_first_impact(const FirstFlights& flights) { return flights.v_mps / std::clamp(flights.eps, 0.1, 1.0); }

double ln_release_height(const FirstFlights& flights, const OneAirAndContact& one, double eps) {
  constexpr double kLeastEps = 0.05, kHighest_m = 1e4;  // at its limit speed a ball may come from anywhere
  const double launch_mps = one.flight_before(flights.v_mps, eps).launch_mps;
  return log(std::min(kHighest_m, one.fall_height_m(launch_mps / std::max(kLeastEps, eps))));
}

void add_heights(const FirstFlights& flights, const Estimate& ln_height, std::vector<ReleaseHeight>& heights) {
  const double reach = 0.5 * (ln_height.ci95->hi - ln_height.ci95->lo);
  for (const RestitutionSample& s : flights.samples) {
    const auto height = [&, ln_ratio = 2.0 * log(s.v_mps / flights.v_mps)](double ln_height_m) {
      return exp(ln_height_m + ln_ratio);
    };
    // the timing of the flight is an error apart
    constexpr double k95 = 1.959963984540054;
    const double timing = k95 * 2.0 * s.sigma_v_mps.value_or(0.0) / s.v_mps;
    const double more = reach > 0.0 ? hypot(reach, timing) / reach : 1.0;
    const auto end = [&](double ln_end) { return height(ln_height.value + more * (ln_end - ln_height.value)); };
    Estimate e;
    e.value = height(ln_height.value);
    e.ci68 = Interval{end(ln_height.ci68->lo), end(ln_height.ci68->hi)};
    e.ci95 = Interval{end(ln_height.ci95->lo), end(ln_height.ci95->hi)};
    e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
    heights.push_back({s.recording, s.drop, e});
  }
}

}  // namespace bouncelab::fit
