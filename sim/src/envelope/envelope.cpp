// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/envelope.hpp"

#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>

#include "bouncelab/core/parallel.hpp"
#include "envelope/cube_cell.hpp"
#include "envelope/dominance.hpp"
#include "envelope/floor_map.hpp"

namespace bouncelab::sim {
namespace {

using Site = Envelope::Site;
using Node = Envelope::Node;
using Patch = Envelope::Patch;
using List = std::vector<std::uint32_t>;

/// Lists up to this length are not split: shorter ones cost more memory and levels than they save comparisons.
constexpr std::size_t kListLength = 16;
/// Where more sites than kListLength meet in one point (a regular surface), splitting never ends by itself; a cell of
/// level 24 is 1e-7 wide.
constexpr int kMaxDepth = 24;

/// Patches are ordered by face, then ib, then ia; the index of face 6 is their number.
std::size_t patch_index(int face, int ia, int ib, int n_side) {
  const auto n = static_cast<std::size_t>(n_side);
  return (static_cast<std::size_t>(face) * n + static_cast<std::size_t>(ib)) * n + static_cast<std::size_t>(ia);
}

float rounded_up(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

/// Grows the quadtree of one patch.
class PatchBuilder {
 public:
  PatchBuilder(const FloorMap& floors, std::vector<Site> sites, Patch& patch)
      : floors_(floors), sites_(std::move(sites)), place_(sites_.size(), kNowhere), patch_(patch) {}

  void build(const CubeCell& cell) {
    List all(sites_.size());
    std::iota(all.begin(), all.end(), 0U);
    patch_.nodes.emplace_back();
    grow(0, cell, all, 0);
    patch_.nodes.shrink_to_fit();
    patch_.lists.shrink_to_fit();
    patch_.sites.shrink_to_fit();
  }

 private:
  static constexpr std::uint32_t kNowhere = 0xffffffffU;

  void grow(std::size_t node, const CubeCell& cell, const List& wider, int depth) {
    const Region region(cell);
    const List list = contenders_within(region, floors_.elevation_at_least(cell), sites_, wider);
    double top = 0.0;
    for (const std::uint32_t k : list) top = std::max(top, elevation_at_most(sites_[k], region));
    patch_.nodes[node].max_elevation = rounded_up(top);
    if (list.size() <= kListLength || depth == kMaxDepth) {
      make_leaf(node, cell.face, list);
      return;
    }
    const std::size_t first = patch_.nodes.size();
    patch_.nodes[node].first = static_cast<std::uint32_t>(first);
    patch_.nodes[node].n_list = kNowhere;
    patch_.nodes.resize(first + 4);
    for (int child = 0; child < 4; ++child)
      grow(first + static_cast<std::size_t>(child), child_of(cell, child), list, depth + 1);
  }

  void make_leaf(std::size_t node, int face, const List& list) {
    patch_.nodes[node].first = static_cast<std::uint32_t>(patch_.lists.size());
    patch_.nodes[node].n_list = static_cast<std::uint32_t>(list.size());
    for (const std::uint32_t k : list) {
      if (place_[k] == kNowhere) {
        place_[k] = static_cast<std::uint32_t>(patch_.sites.size());
        patch_.sites.push_back(sites_[k]);
        patch_.sites.back().direction = from_face(face, sites_[k].direction);
      }
      patch_.lists.push_back(place_[k]);
    }
  }

  const FloorMap& floors_;
  std::vector<Site> sites_;
  List place_;  ///< in the patch's sites, by working index
  Patch& patch_;
};

bool is_inner(const Node& node) { return node.n_list == 0xffffffffU; }

/// Range of patches along an edge of the cube, [first, last].
struct PatchRange {
  int first = 0, last = -1;
};

/// Patches whose regions a cap around u meets along one coordinate of a face: its outline is touched by the planes
/// y = a x with (u.y - a u.x)^2 = s^2 (1 + a^2), s the sine of the cap's half-angle.
PatchRange patches_met(double along, double normal, double s, int n_side) {
  const double below = normal * normal - s * s;
  if (normal <= s || below < 1e-6) return {0, n_side - 1};
  const double spread = s * std::sqrt(std::max(0.0, below + along * along));
  const double lo = (normal * along - spread) / below, hi = (normal * along + spread) / below;
  const double margin = kRegionMargin - 1.0;
  const auto index = [n_side](double a, double shift) {
    return static_cast<int>(std::floor(std::clamp((a + 1.0) * 0.5 * n_side + shift, -1.0, n_side + 1.0)));
  };
  return {std::max(0, index(lo, -0.5 * margin)), std::min(n_side - 1, index(hi, 0.5 * margin))};
}

/// Calls with every patch in whose region an asperity rises above the envelope's least elevation (and a few more).
/// @param rise  of the asperity above that elevation
template <class Function>
void for_each_patch(const Asperity& asperity, double rise, int n_side, const Function& function) {
  if (rise < 0.0) return;
  // |n - u| = sqrt(2 rise) = 2 sin(angle / 2)
  const double s = std::sqrt(2.0 * rise * (1.0 - 0.5 * rise));
  for (int face = 0; face < 6; ++face) {
    const Vector3 u = to_face(face, asperity.direction);
    if (u.x < 0.4 - s) continue;  // no region reaches farther from its face's centre than this
    const PatchRange a = patches_met(u.y, u.x, s, n_side), b = patches_met(u.z, u.x, s, n_side);
    for (int ib = b.first; ib <= b.last; ++ib)
      for (int ia = a.first; ia <= a.last; ++ia) function(patch_index(face, ia, ib, n_side));
  }
}

/// The asperities of each patch, one patch after the other.
struct Distribution {
  std::vector<std::size_t> begin;  ///< of each patch's part of `asperities`, and the end
  List asperities;
};

Distribution distribute(const Ball& ball, const Surface& surface, int n_side, double least_elevation) {
  Distribution d;
  d.begin.assign(static_cast<std::size_t>(6 * n_side * n_side) + 1, 0);
  const auto visit = [&](const auto& function) {
    for (std::size_t j = 0; j < surface.asperities.size(); ++j)
      for_each_patch(surface.asperities[j], surface.asperities[j].radius_m / ball.radius_m - least_elevation, n_side,
                     [&](std::size_t patch) { function(patch, static_cast<std::uint32_t>(j)); });
  };
  visit([&](std::size_t patch, std::uint32_t) { ++d.begin[patch + 1]; });
  std::partial_sum(d.begin.begin(), d.begin.end(), d.begin.begin());
  d.asperities.resize(d.begin.back());
  std::vector<std::size_t> next(d.begin.begin(), d.begin.end() - 1);
  visit([&](std::size_t patch, std::uint32_t j) { d.asperities[next[patch]++] = j; });
  return d;
}

/// Sites of one patch, in the frame of its face.
std::vector<Site> sites_of(const Ball& ball, const Surface& surface, const Distribution& d, std::size_t patch,
                           int face) {
  std::vector<Site> sites;
  sites.reserve(d.begin[patch + 1] - d.begin[patch]);
  for (std::size_t k = d.begin[patch]; k < d.begin[patch + 1]; ++k) {
    const std::uint32_t j = d.asperities[k];
    const Asperity& asperity = surface.asperities[j];
    sites.push_back({to_face(face, asperity.direction), asperity.radius_m / ball.radius_m, j});
  }
  return sites;
}

CubeCell cell_of_patch(std::size_t patch, int n_side) {
  const auto k = static_cast<int>(patch);
  const double h = 1.0 / n_side;
  return {k / (n_side * n_side), (2 * (k % n_side) + 1) * h - 1.0, (2 * (k / n_side % n_side) + 1) * h - 1.0, h};
}

}  // namespace

Envelope::Envelope(const Ball& ball, const Surface& surface, int n_threads, const ProgressCallback& progress) {
  // 600 to 2,500 asperities to a patch: few enough to stay in the fast cache while its tree is grown
  while (6.0 * n_side_ * n_side_ * 2500.0 < static_cast<double>(surface.asperities.size())) n_side_ *= 2;
  patches_.resize(patch_index(6, 0, 0, n_side_));
  const FloorMap floors(ball, surface, (kRegionMargin - 1.0) / n_side_);
  const Distribution distribution = distribute(ball, surface, n_side_, floors.least());
  std::mutex mutex;
  std::size_t n_done = 0;
  parallel_for(patches_.size(), n_threads, [&](std::size_t patch) {
    const CubeCell cell = cell_of_patch(patch, n_side_);
    PatchBuilder(floors, sites_of(ball, surface, distribution, patch, cell.face), patches_[patch]).build(cell);
    if (!progress) return;
    const std::lock_guard lock(mutex);
    progress(static_cast<double>(++n_done), static_cast<double>(patches_.size()));
  });
  for (const Patch& patch : patches_)
    max_elevation_ = std::max(max_elevation_, static_cast<double>(patch.nodes.front().max_elevation));
}

Envelope::Cell Envelope::find(Vector3 n, double elevation) const {
  const CubePoint point = cube_point(n);
  const auto index_along = [&](double x) {
    return std::clamp(static_cast<int>((x + 1.0) * 0.5 * n_side_), 0, n_side_ - 1);
  };
  const int ia = index_along(point.a), ib = index_along(point.b);
  const std::size_t place = patch_index(point.face, ia, ib, n_side_);
  const Patch& patch = patches_[place];
  CubeCell cell = cell_of_patch(place, n_side_);
  const Node* node = &patch.nodes.front();
  while (is_inner(*node) && !(static_cast<double>(node->max_elevation) < elevation)) {
    const int child = (point.a >= cell.a ? 1 : 0) + (point.b >= cell.b ? 2 : 0);
    node = &patch.nodes[node->first + static_cast<std::uint32_t>(child)];
    cell = child_of(cell, child);
  }
  Cell found{
      margin_in_region(cell, point.a, point.b), static_cast<double>(node->max_elevation), !is_inner(*node), {}, {}};
  if (found.is_leaf) {
    found.list = std::span(patch.lists).subspan(node->first, node->n_list);
    found.sites = patch.sites;
  }
  return found;
}

Envelope::Support Envelope::support(Vector3 n) const {
  const Cell cell = find(n, -1.0);
  Support support;
  for (const std::uint32_t k : cell.list) {
    const Site& site = cell.sites[k];
    const double elevation = site.height - 0.5 * norm2(n - site.direction);
    if (elevation > support.elevation) support = {elevation, site.asperity};
  }
  return support;
}

std::int64_t Envelope::n_sites() const {
  std::int64_t n = 0;
  for (const Patch& patch : patches_) n += static_cast<std::int64_t>(patch.sites.size());
  return n;
}

std::int64_t Envelope::n_bytes() const {
  std::size_t n = patches_.size() * sizeof(Patch);
  for (const Patch& patch : patches_)
    n += patch.nodes.size() * sizeof(Node) + patch.lists.size() * sizeof(std::uint32_t) +
         patch.sites.size() * sizeof(Site);
  return static_cast<std::int64_t>(n);
}

}  // namespace bouncelab::sim
