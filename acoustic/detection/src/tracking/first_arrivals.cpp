// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/first_arrivals.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace bouncelab::detection {
namespace {

constexpr double kSteps_s = 8e-3;        // within which a sound may rise in steps; an echo follows later
constexpr double kShareOfFlight = 0.25;  // or within this share of the intervals around
constexpr double kAlike_s = 0.5e-3;      // candidates of the shortest window are no nearer to each other
constexpr double kAlikeOfReach = 0.5;    // those of longer windows err by more
constexpr double kFaint = 0.3;           // of the impact's amplitude: a forerunner (candidates.cpp) is no beginning
constexpr std::ptrdiff_t kFewest = 3;

/// Candidates around one impact.
struct Surroundings {
  std::vector<double> offset_s;  // from the impact
  std::vector<std::size_t> candidate;
};

Surroundings surroundings(const std::vector<Candidate>& c, const Track& track, std::size_t k) {
  const std::size_t own = track.impacts[k].candidate;
  double reach_s = kSteps_s;
  if (k > 0) reach_s = std::min(reach_s, kShareOfFlight * (c[own].t_s - c[track.impacts[k - 1].candidate].t_s));
  if (k + 1 < track.impacts.size())
    reach_s = std::min(reach_s, kShareOfFlight * (c[track.impacts[k + 1].candidate].t_s - c[own].t_s));
  Surroundings around;
  const auto add = [&](std::size_t j) {
    if (c[j].amplitude < kFaint * c[own].amplitude) return;
    around.offset_s.push_back(c[j].t_s - c[own].t_s);
    around.candidate.push_back(j);
  };
  for (std::size_t j = own; j-- > 0 && c[own].t_s - c[j].t_s <= reach_s;) add(j);
  for (std::size_t j = own + 1; j < c.size() && c[j].t_s - c[own].t_s <= reach_s; ++j) add(j);
  return around;
}

/// The candidate nearest to an offset, where one is near.
std::optional<std::size_t> at_offset(const std::vector<Candidate>& c, const Surroundings& around, double offset_s) {
  std::optional<std::size_t> found;
  double nearest = 1.0;
  for (std::size_t i = 0; i < around.offset_s.size(); ++i) {
    const double alike_s = std::max(kAlike_s, kAlikeOfReach * c[around.candidate[i]].reach_s);
    const double off = std::abs(around.offset_s[i] - offset_s) / alike_s;
    if (off < nearest) nearest = off, found = around.candidate[i];
  }
  return found;
}

/// The step that most impacts of a track have, if it is at least half of them.
std::optional<double> common_step(const std::vector<Candidate>& c, const std::vector<Surroundings>& all) {
  std::optional<double> step_s;
  std::ptrdiff_t most = std::max(kFewest, (std::ssize(all) + 1) / 2) - 1;
  for (const Surroundings& one : all)
    for (const double offset_s : one.offset_s) {
      if (offset_s > 0.0) continue;  // none would begin earlier
      const std::ptrdiff_t n = std::count_if(all.begin(), all.end(), [&](const Surroundings& around) {
        return at_offset(c, around, offset_s) || at_offset(c, around, -offset_s);
      });
      if (n > most) most = n, step_s = -offset_s;
    }
  return step_s;
}

/// Whether any impact begins earlier now.
bool begin_earlier(const std::vector<Candidate>& c, Track& track) {
  std::vector<Surroundings> all;
  for (std::size_t k = 0; k < track.impacts.size(); ++k) all.push_back(surroundings(c, track, k));
  const std::optional<double> step_s = common_step(c, all);
  if (!step_s) return false;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (const auto first = at_offset(c, all[k], -*step_s)) track.impacts[k].candidate = *first;
  return true;
}

}  // namespace

void begin_at_first_arrivals(const std::vector<Candidate>& candidates, std::vector<Track>& tracks) {
  constexpr int kMostSteps = 4;
  for (Track& track : tracks)
    for (int step = 0; step < kMostSteps && begin_earlier(candidates, track); ++step) {
    }
}

}  // namespace bouncelab::detection
