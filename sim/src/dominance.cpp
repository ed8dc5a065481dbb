// SPDX-License-Identifier: GPL-3.0-or-later
#include "dominance.hpp"

#include <array>

namespace bouncelab {
namespace {

using Site = Envelope::Site;

/// e_rival - e_site is linear in n and changes by at most r |u_rival - u_site| over the cap.
bool is_dominated(const Site& site, const Site& rival, const Cap& cap) {
  const Vector3 apart = rival.direction - site.direction;
  const double lead = dot(cap.centre, apart) + (rival.height - site.height);
  return lead >= 0.0 && lead * lead >= cap.radius * cap.radius * norm2(apart);
}

struct Rivals {
  std::array<std::uint32_t, 5> highest{};  ///< at the centre and at four points around it
  double floor = 0.0;                      ///< the envelope is nowhere in the cap lower than this
};

Rivals find_rivals(std::span<const Site> sites, const std::vector<std::uint32_t>& candidates, const Cap& cap) {
  const Vector3 c = cap.centre;
  const Vector3 helper = std::abs(c.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  const Vector3 e1 = (0.75 * cap.radius) * normalized(cross(c, helper));
  const Vector3 e2 = cross(c, e1);
  Rivals rivals;
  rivals.highest.fill(candidates.front());
  std::array<double, 5> best{};
  best.fill(-2.0);
  for (const std::uint32_t k : candidates) {
    const Site& site = sites[k];
    const double middle = dot(c, site.direction) + site.height;
    const double d1 = dot(e1, site.direction), d2 = dot(e2, site.direction);
    const std::array<double, 5> values{middle, middle + d1, middle - d1, middle + d2, middle - d2};
    for (std::size_t p = 0; p < 5; ++p) {
      if (values[p] > best[p]) {
        best[p] = values[p];
        rivals.highest[p] = k;
      }
    }
    rivals.floor = std::max(rivals.floor, elevation_at_least(site, cap));
  }
  return rivals;
}

}  // namespace

void keep_what_can_be_highest(std::span<const Site> sites, const std::vector<std::uint32_t>& candidates, const Cap& cap,
                              std::vector<std::uint32_t>& kept) {
  kept.clear();
  if (candidates.empty()) return;
  const Rivals rivals = find_rivals(sites, candidates, cap);
  for (const std::uint32_t k : candidates) {
    if (elevation_at_most(sites[k], cap) < rivals.floor) continue;
    bool dominated = false;
    for (const std::uint32_t rival : rivals.highest)
      dominated = dominated || (rival != k && is_dominated(sites[k], sites[rival], cap));
    if (!dominated) kept.push_back(k);
  }
}

void drop_dominated_pairs(std::span<const Site> sites, const Cap& cap, std::vector<std::uint32_t>& list) {
  std::size_t n_kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    bool dominated = false;
    // against those kept and those still to come: what was dropped was dropped by one that dominates here too
    for (std::size_t k = 0; k < n_kept && !dominated; ++k)
      dominated = is_dominated(sites[list[i]], sites[list[k]], cap);
    for (std::size_t k = i + 1; k < list.size() && !dominated; ++k)
      dominated =
          is_dominated(sites[list[i]], sites[list[k]], cap) && !is_dominated(sites[list[k]], sites[list[i]], cap);
    if (!dominated) list[n_kept++] = list[i];
  }
  list.resize(n_kept);
}

}  // namespace bouncelab
