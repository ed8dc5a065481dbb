// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/dominance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace bouncelab::sim {
namespace {

using Site = Envelope::Site;
using List = std::vector<std::uint32_t>;

/// Lists up to this length are compared with five competitors, and longer ones that the floor no longer halves.
constexpr std::size_t kCompetitorsLength = 64;
/// Up to this length every pair is compared, unless the list is short enough already.
constexpr std::size_t kPairsLength = 24;
constexpr std::size_t kShortLength = 8;

/// A site in a region with X = (1, a, b), |a - a0| <= half, |b - b0| <= half: it reaches there
/// |X| (e + 1) = (u.X0 + y (a - a0) + z (b - b0)) + height |X|.
struct Bid {
  double centre, y, z, height;  ///< centre: u.X0
};

std::vector<Bid> bids_of(std::span<const Site> sites, const List& list, const Region& region) {
  std::vector<Bid> bids(list.size());
  const Vector3 x0 = region.centre();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Site& site = sites[list[i]];
    bids[i] = {dot(site.direction, x0), site.direction.y, site.direction.z, site.height};
  }
  return bids;
}

/// The least that `competitor` is above `bid` in the region, times |X|; >= 0 where it beats the bid everywhere. The
/// rounding of u.X0 makes it uncertain by 4e-16: 1e-18 m of a ball of 3 mm.
double least_lead(const Bid& bid, const Bid& competitor, const Region& region) {
  const double higher = competitor.height - bid.height;
  return (competitor.centre - bid.centre) -
         region.half() * (std::abs(competitor.y - bid.y) + std::abs(competitor.z - bid.z)) +
         (higher * region.shortest() + std::min(higher, 0.0) * (region.longest() - region.shortest()));
}

using Competitors = std::array<std::size_t, 5>;

/// The highest at the centre and at four points around it.
Competitors find_competitors(const std::vector<Bid>& bids, const Region& region) {
  const double step = 0.7 * region.half(), length = 0.5 * (region.shortest() + region.longest());
  Competitors competitors{};
  std::array<double, 5> best;
  best.fill(-2.0);
  for (std::size_t i = 0; i < bids.size(); ++i) {
    const double centre = bids[i].centre + length * bids[i].height, y = step * bids[i].y, z = step * bids[i].z;
    const std::array<double, 5> reach{centre, centre + (y + z), centre - (y + z), centre + (y - z), centre - (y - z)};
    for (std::size_t p = 0; p < 5; ++p) {
      if (reach[p] <= best[p]) continue;
      best[p] = reach[p];
      competitors[p] = i;
    }
  }
  return competitors;
}

void drop_what_competitors_beat(std::span<const Site> sites, const Region& region, List& list) {
  const std::vector<Bid> bids = bids_of(sites, list, region);
  const Competitors competitors = find_competitors(bids, region);
  std::size_t n_kept = 0;
  for (std::size_t i = 0; i < bids.size(); ++i) {
    const bool is_beaten = std::any_of(competitors.begin(), competitors.end(), [&](std::size_t competitor) {
      return competitor != i && least_lead(bids[i], bids[competitor], region) >= 0.0;
    });
    list[n_kept] = list[i];
    n_kept += is_beaten ? 0 : 1;
  }
  list.resize(n_kept);
}

/// Is bid i beaten by any other? Of equal ones the first is not.
bool is_beaten_by_any(const std::vector<Bid>& bids, std::size_t i, const Region& region) {
  int n_better = 0;  // without branches: most often there is none
  for (const Bid& competitor : bids) n_better += least_lead(bids[i], competitor, region) >= 0.0 ? 1 : 0;
  if (n_better <= 1) return false;  // itself
  for (std::size_t k = 0; k < bids.size(); ++k)
    if (k != i && least_lead(bids[i], bids[k], region) >= 0.0 &&
        (k < i || !(least_lead(bids[k], bids[i], region) >= 0.0)))
      return true;
  return false;
}

void drop_what_any_beats(std::span<const Site> sites, const Region& region, List& list) {
  const std::vector<Bid> bids = bids_of(sites, list, region);
  std::size_t n_kept = 0;
  for (std::size_t i = 0; i < bids.size(); ++i) {
    // those dropped count as competitors too: what beats them beats this
    const bool is_beaten = is_beaten_by_any(bids, i, region);
    list[n_kept] = list[i];
    n_kept += is_beaten ? 0 : 1;
  }
  list.resize(n_kept);
}

/// What reaches the floor somewhere in the region.
List above_floor(const Region& region, double floor, std::span<const Site> sites, const List& wider) {
  List within(wider.size());
  std::size_t n = 0;
  for (const std::uint32_t k : wider) {
    within[n] = k;
    n += elevation_at_most(sites[k], region) >= floor ? 1 : 0;
  }
  within.resize(n);
  return within;
}

}  // namespace

List contenders_within(const Region& region, double floor, std::span<const Site> sites, const List& wider) {
  List within = above_floor(region, floor, sites, wider);
  if (!within.empty() && (within.size() <= kCompetitorsLength || 2 * within.size() > wider.size()))
    drop_what_competitors_beat(sites, region, within);
  if (within.size() > kShortLength && within.size() <= kPairsLength) drop_what_any_beats(sites, region, within);
  return within;
}

}  // namespace bouncelab::sim
