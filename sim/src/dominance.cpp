// SPDX-License-Identifier: GPL-3.0-or-later
#include "dominance.hpp"

#include <array>

namespace bouncelab {
namespace {

using Site = Envelope::Site;
using List = std::vector<std::uint32_t>;

/// Lists up to this length are held against rivals, longer ones against a floor.
constexpr std::size_t kRivalsLength = 64;
/// Up to this length every pair is compared, unless the list is short enough already.
constexpr std::size_t kPairsLength = 20;
constexpr std::size_t kShortLength = 8;

/// The envelope's guaranteed elevation in a region, by squares: the highest site in a square is nowhere in it seen
/// lower than height - diameter^2/2.
class Floor {
 public:
  Floor(const Region& region, std::size_t n_sites) : region_(region) {
    // about four sites to a square
    while (n_side_ < kMostSquares && static_cast<std::size_t>(4 * 4 * n_side_ * n_side_) <= n_sites) n_side_ *= 2;
    std::fill_n(highest_.begin(), n_side_ * n_side_, 0.0);
  }

  void add(const Site& site) {
    if (!(site.direction.x > 0.0)) return;
    const auto [x, y] = region_.place(site.direction);
    if (!(std::abs(x) < 1.0 && std::abs(y) < 1.0)) return;
    double& highest = highest_[static_cast<std::size_t>(index(x) + n_side_ * index(y))];
    highest = std::max(highest, site.height);
  }

  double elevation() const {
    const double diameter = region_.square_diameter(n_side_);
    return *std::min_element(highest_.begin(), highest_.begin() + n_side_ * n_side_) - 0.5 * diameter * diameter;
  }

 private:
  static constexpr int kMostSquares = 32;

  int index(double x) const { return static_cast<int>((x + 1.0) * 0.5 * n_side_); }

  const Region& region_;
  int n_side_ = 1;
  std::array<double, static_cast<std::size_t>(kMostSquares* kMostSquares)> highest_;
};

/// @return whether the region has a floor of its own, above the smooth sphere
bool drop_what_lies_below_the_floor(const Region& region, std::span<const Site> sites, Contenders& within) {
  Floor floor(region, within.list.size());
  for (const std::uint32_t k : within.list) floor.add(sites[k]);
  const double elevation = floor.elevation();
  if (elevation > within.floor) {
    within.floor = elevation;
    std::erase_if(within.list, [&](std::uint32_t k) { return elevation_at_most(sites[k], region) < elevation; });
  }
  return elevation > 0.0;
}

/// e_rival - e_site is linear in n.
bool is_dominated(const Site& site, const Site& rival, const Region& region) {
  return region.is_nowhere_negative(rival.direction - site.direction, rival.height - site.height);
}

using Rivals = std::array<std::uint32_t, 5>;

/// The highest at the centre and at four points around it.
Rivals find_rivals(std::span<const Site> sites, const List& list, const Region& region) {
  const std::array<Vector3, 5> points{region.direction(0, 0), region.direction(0.7, 0.7), region.direction(-0.7, 0.7),
                                      region.direction(0.7, -0.7), region.direction(-0.7, -0.7)};
  Rivals rivals;
  rivals.fill(list.front());
  std::array<double, 5> best;
  best.fill(-2.0);
  for (const std::uint32_t k : list) {
    const Site& site = sites[k];
    for (std::size_t p = 0; p < 5; ++p) {
      const double elevation = dot(points[p], site.direction) + site.height;
      if (elevation > best[p]) {
        best[p] = elevation;
        rivals[p] = k;
      }
    }
  }
  return rivals;
}

void drop_what_rivals_beat(std::span<const Site> sites, const Region& region, List& list) {
  const Rivals rivals = find_rivals(sites, list, region);
  std::size_t n_kept = 0;
  for (const std::uint32_t k : list) {
    bool dominated = false;
    for (const std::uint32_t rival : rivals)
      dominated = dominated || (rival != k && is_dominated(sites[k], sites[rival], region));
    if (!dominated) list[n_kept++] = k;
  }
  list.resize(n_kept);
}

void drop_what_any_beats(std::span<const Site> sites, const Region& region, List& list) {
  std::size_t n_kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    bool dominated = false;
    // those kept and those still to come are enough: what was dropped is beaten by one that beats this too
    for (std::size_t k = 0; k < n_kept && !dominated; ++k)
      dominated = is_dominated(sites[list[i]], sites[list[k]], region);
    for (std::size_t k = i + 1; k < list.size() && !dominated; ++k)
      dominated =
          is_dominated(sites[list[i]], sites[list[k]], region) && !is_dominated(sites[list[k]], sites[list[i]], region);
    if (!dominated) list[n_kept++] = list[i];
  }
  list.resize(n_kept);
}

}  // namespace

Contenders contenders_within(const Region& region, std::span<const Site> sites, const Contenders& wider) {
  Contenders within;
  within.floor = wider.floor;
  within.list.reserve(wider.list.size());
  for (const std::uint32_t k : wider.list)
    if (elevation_at_most(sites[k], region) >= wider.floor) within.list.push_back(k);

  // a floor drops more than rivals do while the region is wide; it has none once squares are empty
  const bool is_wide = within.list.size() > kRivalsLength && drop_what_lies_below_the_floor(region, sites, within);
  if (!within.list.empty() && !is_wide) drop_what_rivals_beat(sites, region, within.list);
  if (within.list.size() > kShortLength && within.list.size() <= kPairsLength)
    drop_what_any_beats(sites, region, within.list);
  return within;
}

}  // namespace bouncelab
