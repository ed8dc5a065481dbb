// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/own_sounds.hpp"

#include <algorithm>

namespace bouncelab::detection {

namespace {

constexpr double kEchoOfFlight = 0.15;  // where it is short, what follows may be anything

}  // namespace

std::vector<std::size_t> explained_by(const Observations& o, const std::vector<std::size_t>& own) {
  const std::vector<Candidate>& c = o.candidates();
  std::vector<std::size_t> explained;
  for (std::size_t n = 0; n < own.size(); ++n) {
    const bool is_last = n + 1 == own.size();
    const double flight_s = is_last ? c[own[n]].t_s - c[own[n - 1]].t_s : c[own[n + 1]].t_s - c[own[n]].t_s;
    const double echo_s = std::min(kEcho_s, kEchoOfFlight * flight_s);
    explained.push_back(own[n]);
    for (std::size_t k = own[n] + 1; k < c.size() && c[k].t_s - c[own[n]].t_s < echo_s; ++k)
      if (c[k].amplitude < c[own[n]].amplitude) explained.push_back(k);
  }
  return explained;
}

OwnSounds own_sounds(const Observations& o, const Track& track) {
  OwnSounds own;
  for (const TrackImpact& impact : track.impacts) own.candidates.push_back(impact.candidate);
  own.explained = explained_by(o, own.candidates);
  for (std::size_t n = 0; n < own.candidates.size(); ++n) {
    own.seen.push_back(o.without(own.candidates[n], own.explained));
    if (n > 0) own.same_source.push_back(o.same_source(own.candidates[n - 1], own.candidates[n]));
  }
  return own;
}

}  // namespace bouncelab::detection
