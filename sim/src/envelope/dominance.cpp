// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/patch_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bouncelab::sim {
namespace {

/// Lists up to this length are compared with five competitors, and longer ones that the floor no longer halves.
constexpr std::size_t kCompetitorsLength = 64;
/// Up to this length every pair is compared, unless the list is short enough already.
constexpr std::size_t kPairsLength = 24;
constexpr std::size_t kShortLength = 8;

/// A contender in a region with X = (1, a, b), |a - a0| <= half, |b - b0| <= half: it reaches there
/// |X| (e + 1) = (u.X0 + y (a - a0) + z (b - b0)) + height |X|.
struct Bid {
  double centre, y, z, height;  ///< centre: u.X0
};

/// What two bids are compared by.
struct Bounds {
  double half, shortest, spread;  ///< spread: of |X|
  explicit Bounds(const Region& region)
      : half(region.half()), shortest(region.shortest()), spread(region.longest() - region.shortest()) {}
};

/// The least that `competitor` is above `bid` in the region, times |X|; >= 0 where it beats the bid everywhere. The
/// rounding of u.X0 makes it uncertain by 4e-16: 1e-18 m of a ball of 3 mm.
inline double least_lead(const Bid& bid, const Bid& competitor, const Bounds& bounds) {
  const double higher = competitor.height - bid.height;
  return (competitor.centre - bid.centre) -
         bounds.half * (std::abs(competitor.y - bid.y) + std::abs(competitor.z - bid.z)) +
         (higher * bounds.shortest + (higher < 0.0 ? higher : 0.0) * bounds.spread);
}

/// The bids of a list, by columns.
struct Bids {
  const double *centre, *y, *z, *height;
  std::size_t n;
  Bid operator[](std::size_t i) const { return {centre[i], y[i], z[i], height[i]}; }
};

Bids make_bids(const Region& region, const Contenders& list, ContenderScratch& scratch) {
  const Vector3 x0 = region.centre();
  scratch.centre.resize(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) scratch.centre[i] = dot(Vector3{list.x[i], list.y[i], list.z[i]}, x0);
  return {scratch.centre.data(), list.y.data(), list.z.data(), list.height.data(), list.size()};
}

using Competitors = std::array<std::size_t, 5>;

/// The highest at the centre and at four points around it; of equal ones the first.
Competitors find_competitors(const Bids& bids, const Region& region) {
  const double step = 0.7 * region.half(), length = 0.5 * (region.shortest() + region.longest());
  Competitors competitors{};
  std::array<double, 5> best;
  best.fill(-2.0);
  for (std::size_t i = 0; i < bids.n; ++i) {
    const double centre = bids.centre[i] + length * bids.height[i], y = step * bids.y[i], z = step * bids.z[i];
    const std::array<double, 5> reach{centre, centre + (y + z), centre - (y + z), centre + (y - z), centre - (y - z)};
    for (std::size_t p = 0; p < 5; ++p) {
      competitors[p] = reach[p] > best[p] ? i : competitors[p];
      best[p] = reach[p] > best[p] ? reach[p] : best[p];
    }
  }
  return competitors;
}

/// Keeps the contenders that are not beaten, in their order.
void drop_beaten(const std::vector<std::uint8_t>& is_beaten, Contenders& list) {
  std::size_t n_kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    list.set(n_kept, list, i);
    n_kept += is_beaten[i] == 0 ? 1 : 0;
  }
  list.resize(n_kept);
}

/// What the one bid is that all are held against.
enum class Role { bid, competitor };

/// The least leads over each bid of the one given, as the competitor, or of each over it.
void find_leads(const Bids& bids, const Bid bid, Role role, const Bounds bounds, std::vector<double>& leads) {
  leads.resize(bids.n);
  const double *const centre = bids.centre, *const y = bids.y, *const z = bids.z, *const height = bids.height;
  double* __restrict const lead = leads.data();
  const std::size_t n = bids.n;
  if (role == Role::competitor)
    for (std::size_t i = 0; i < n; ++i) lead[i] = least_lead({centre[i], y[i], z[i], height[i]}, bid, bounds);
  else
    for (std::size_t i = 0; i < n; ++i) lead[i] = least_lead(bid, {centre[i], y[i], z[i], height[i]}, bounds);
}

void drop_what_competitors_beat(const Region& region, Contenders& list, ContenderScratch& scratch) {
  const Bids bids = make_bids(region, list, scratch);
  const Bounds bounds(region);
  scratch.is_beaten.assign(bids.n, 0);
  for (const std::size_t k : find_competitors(bids, region)) {
    find_leads(bids, bids[k], Role::competitor, bounds, scratch.lead);
    scratch.lead[k] = -1.0;  // nothing beats itself
    for (std::size_t i = 0; i < bids.n; ++i)
      scratch.is_beaten[i] = static_cast<std::uint8_t>(scratch.is_beaten[i] | (scratch.lead[i] >= 0.0 ? 1U : 0U));
  }
  drop_beaten(scratch.is_beaten, list);
}

/// Is bid i beaten by any other? Of equal ones the first is not.
bool is_beaten_by_any(const Bids& bids, std::size_t i, const Bounds& bounds, std::vector<double>& lead) {
  const Bid bid = bids[i];
  find_leads(bids, bid, Role::bid, bounds, lead);
  int n_better = 0;  // without branches: most often there is none
  for (const double l : lead) n_better += l >= 0.0 ? 1 : 0;
  if (n_better <= 1) return false;  // itself
  for (std::size_t k = 0; k < bids.n; ++k)
    if (k != i && lead[k] >= 0.0 && (k < i || !(least_lead(bids[k], bid, bounds) >= 0.0))) return true;
  return false;
}

void drop_what_any_beats(const Region& region, Contenders& list, ContenderScratch& scratch) {
  const Bids bids = make_bids(region, list, scratch);
  const Bounds bounds(region);
  scratch.is_beaten.resize(bids.n);
  // those dropped count as competitors too: what beats them beats this
  for (std::size_t i = 0; i < bids.n; ++i)
    scratch.is_beaten[i] = is_beaten_by_any(bids, i, bounds, scratch.lead) ? 1 : 0;
  drop_beaten(scratch.is_beaten, list);
}

/// What reaches the floor somewhere in the region.
void find_above_floor(const Region& region, double floor, const Contenders& wider, Contenders& within,
                      ContenderScratch& scratch) {
  elevations_at_most(region, wider, scratch.elevation);
  within.resize(wider.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < wider.size(); ++i) {
    within.set(n, wider, i);
    n += scratch.elevation[i] >= floor ? 1 : 0;
  }
  within.resize(n);
}

}  // namespace

void elevations_at_most(const Region& region, const Contenders& list, std::vector<double>& elevation) {
  elevation.resize(list.size());
  const Region here = region;  // which no write to the result can change
  double* __restrict const result = elevation.data();
  const double *const x = list.x.data(), *const y = list.y.data(), *const z = list.z.data();
  const double* const height = list.height.data();
  const std::size_t n = list.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double distance = here.distance_at_least({x[i], y[i], z[i]});
    result[i] = height[i] - 0.5 * distance * distance;
  }
}

void find_contenders_within(const Region& region, double floor, const Contenders& wider, Contenders& within,
                            ContenderScratch& scratch) {
  find_above_floor(region, floor, wider, within, scratch);
  if (within.size() > 0 && (within.size() <= kCompetitorsLength || 2 * within.size() > wider.size()))
    drop_what_competitors_beat(region, within, scratch);
  if (within.size() > kShortLength && within.size() <= kPairsLength) drop_what_any_beats(region, within, scratch);
}

namespace {

/// Neighbours looked at on each side.
constexpr int kRings = 2;

float rounded_down(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}

/// A square map of n_side^2 values, gnomonic coordinates from -half_width to half_width.
struct Grid {
  int n_side;
  double half_width;

  double side() const { return 2.0 * half_width / n_side; }
  std::size_t place(int ia, int ib) const {
    return static_cast<std::size_t>(ib) * static_cast<std::size_t>(n_side) + static_cast<std::size_t>(ia);
  }
  int index(double x) const { return std::clamp(static_cast<int>((x + half_width) / side()), 0, n_side - 1); }
  /// Least |(1, a, b)| of the squares within kRings of one.
  double shortest2(int ia, int ib) const {
    const auto least = [&](int i) {
      return std::max(0.0, std::abs((i + 0.5) * side() - half_width) - (kRings + 0.5) * side());
    };
    return 1.0 + least(ia) * least(ia) + least(ib) * least(ib);
  }
};

double floor_by_neighbours(const Grid& grid, std::span<const float> highest, int ia, int ib) {
  // |X/|X| - Y/|Y||^2 <= |X - Y|^2 / (|X| |Y|)
  const double half_side2 = 0.5 * grid.side() * grid.side() / grid.shortest2(ia, ib);
  double floor = 0.0;
  for (int jb = std::max(0, ib - kRings); jb <= std::min(grid.n_side - 1, ib + kRings); ++jb) {
    const int db = std::abs(jb - ib) + 1;
    for (int ja = std::max(0, ia - kRings); ja <= std::min(grid.n_side - 1, ia + kRings); ++ja) {
      const int da = std::abs(ja - ia) + 1;
      floor = std::max(floor, static_cast<double>(highest[grid.place(ja, jb)]) - half_side2 * (da * da + db * db));
    }
  }
  return floor;
}

std::vector<float> halved(const Grid& grid, std::span<const float> highest) {
  const Grid coarse{grid.n_side / 2, grid.half_width};
  std::vector<float> result(coarse.place(0, coarse.n_side));
  for (int ib = 0; ib < grid.n_side; ++ib)
    for (int ia = 0; ia < grid.n_side; ++ia) {
      float& top = result[coarse.place(ia / 2, ib / 2)];
      top = std::max(top, highest[grid.place(ia, ib)]);
    }
  return result;
}

/// Floors of one face's squares. @param floors  result, as large as `highest`
void find_floors(const Grid& grid, std::span<const float> highest, std::span<float> floors) {
  const Grid coarse{grid.n_side / 2, grid.half_width};
  std::vector<float> wide(grid.n_side > 1 ? coarse.place(0, coarse.n_side) : 0);
  if (grid.n_side > 1) find_floors(coarse, halved(grid, highest), wide);
  for (int ib = 0; ib < grid.n_side; ++ib)
    for (int ia = 0; ia < grid.n_side; ++ia) {
      const float own = rounded_down(floor_by_neighbours(grid, highest, ia, ib));
      floors[grid.place(ia, ib)] = grid.n_side > 1 ? std::max(own, wide[coarse.place(ia / 2, ib / 2)]) : own;
    }
}

/// The height of the highest asperity in each square of each face; 0 where there is none.
std::vector<float> highest_by_square(const Ball& ball, const Surface& surface, const Grid& grid) {
  const std::size_t n_face = grid.place(0, grid.n_side);
  std::vector<float> highest(6 * n_face);
  for (const Asperity& asperity : surface.asperities) {
    const float height = rounded_down(asperity.radius_m / ball.radius_m);
    for (int face = 0; face < 6; ++face) {
      const Vector3 u = to_face(face, asperity.direction);
      const double reach = grid.half_width * u.x;
      if (!(std::abs(u.y) < reach && std::abs(u.z) < reach)) continue;
      float& top =
          highest[static_cast<std::size_t>(face) * n_face + grid.place(grid.index(u.y / u.x), grid.index(u.z / u.x))];
      top = std::max(top, height);
    }
  }
  return highest;
}

}  // namespace

FloorMap::FloorMap(const Ball& ball, const Surface& surface, double margin) : half_width_(1.0 + margin) {
  // half an asperity to two of them to a square
  while (12.0 * n_side_ * n_side_ <= static_cast<double>(surface.asperities.size())) n_side_ *= 2;
  const Grid grid{n_side_, half_width_};
  const std::vector<float> highest = highest_by_square(ball, surface, grid);
  floors_.resize(highest.size());
  const std::size_t n_face = grid.place(0, n_side_);
  for (std::size_t face = 0; face < 6; ++face)
    find_floors(grid, std::span(highest).subspan(face * n_face, n_face),
                std::span(floors_).subspan(face * n_face, n_face));
  least_ = static_cast<double>(*std::min_element(floors_.begin(), floors_.end()));
}

double FloorMap::elevation_at_least(const CubeCell& cell) const {
  const Grid grid{n_side_, half_width_};
  const double h = kRegionMargin * cell.h;
  const int a_first = grid.index(cell.a - h), a_last = grid.index(cell.a + h);
  const int b_first = grid.index(cell.b - h), b_last = grid.index(cell.b + h);
  const float* face = floors_.data() + static_cast<std::size_t>(cell.face) * grid.place(0, n_side_);
  float floor = std::numeric_limits<float>::infinity();
  for (int ib = b_first; ib <= b_last; ++ib)
    for (int ia = a_first; ia <= a_last; ++ia) floor = std::min(floor, face[grid.place(ia, ib)]);
  return static_cast<double>(floor);
}

}  // namespace bouncelab::sim
