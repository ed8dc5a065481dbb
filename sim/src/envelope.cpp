// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/envelope.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <mutex>

#include "cube_cell.hpp"
#include "dominance.hpp"

namespace bouncelab {
namespace {

using Site = Envelope::Site;
using Node = Envelope::Node;
using Patch = Envelope::Patch;
using List = std::vector<std::uint32_t>;

/// Lists up to this length are not split: shorter ones cost more memory and levels than they save looks.
constexpr std::size_t kListLength = 8;
/// Up to this length every pair of a list is compared.
constexpr std::size_t kPairwiseLength = 24;
/// Where more sites than kListLength meet in one point (a regular surface), splitting never ends by itself; a cell of
/// level 24 is 1e-7 wide.
constexpr int kMaxDepth = 24;

float rounded_up(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

/// Grows the quadtree of one patch.
class PatchBuilder {
 public:
  PatchBuilder(std::vector<Site> sites, Patch& patch)
      : sites_(std::move(sites)), place_(sites_.size(), kNowhere), patch_(patch) {}

  void build(const CubeCell& cell) {
    List all(sites_.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<std::uint32_t>(k);
    patch_.nodes.emplace_back();
    grow(0, cell, all, 0);
    patch_.nodes.shrink_to_fit();
    patch_.lists.shrink_to_fit();
    patch_.sites.shrink_to_fit();
  }

 private:
  static constexpr std::uint32_t kNowhere = 0xffffffffU;

  void grow(std::size_t node, const CubeCell& cell, const List& candidates, int depth) {
    const Cap cap = region_of(cell);
    List list;
    keep_what_can_be_highest(sites_, candidates, cap, list);
    if (list.size() <= kPairwiseLength) drop_dominated_pairs(sites_, cap, list);
    double top = 0.0;
    for (const std::uint32_t k : list) top = std::max(top, elevation_at_most(sites_[k], cap));
    patch_.nodes[node].max_elevation = rounded_up(top);
    if (list.size() <= kListLength || depth == kMaxDepth) {
      make_leaf(node, list);
      return;
    }
    const std::size_t first = patch_.nodes.size();
    patch_.nodes[node].first = static_cast<std::uint32_t>(first);
    patch_.nodes[node].n_list = kNowhere;
    patch_.nodes.resize(first + 4);
    for (int child = 0; child < 4; ++child)
      grow(first + static_cast<std::size_t>(child), child_of(cell, child), list, depth + 1);
  }

  void make_leaf(std::size_t node, const List& list) {
    patch_.nodes[node].first = static_cast<std::uint32_t>(patch_.lists.size());
    patch_.nodes[node].n_list = static_cast<std::uint32_t>(list.size());
    for (const std::uint32_t k : list) {
      if (place_[k] == kNowhere) {
        place_[k] = static_cast<std::uint32_t>(patch_.sites.size());
        patch_.sites.push_back(sites_[k]);
      }
      patch_.lists.push_back(place_[k]);
    }
  }

  std::vector<Site> sites_;
  List place_;  ///< in the patch's sites, by working index
  Patch& patch_;
};

bool is_inner(const Node& node) { return node.n_list == 0xffffffffU; }

/// Hands the asperities down from a face of the cube to its patches.
class Distributor {
 public:
  Distributor(const Ball& ball, const Surface& surface, int n_side, std::vector<Patch>& patches,
              const ProgressCallback& progress)
      : ball_(ball), surface_(surface), n_side_(n_side), patches_(patches), progress_(progress) {}

  /// @param candidates  empty pointer: the whole surface
  void descend(const CubeCell& cell, const List* candidates) {
    const Cap cap = region_of(cell);
    List list;
    if (candidates != nullptr) {
      for (const std::uint32_t j : *candidates)
        if (reaches(j, cap)) list.push_back(j);
    } else {
      for (std::size_t j = 0; j < surface_.asperities.size(); ++j)
        if (reaches(j, cap)) list.push_back(static_cast<std::uint32_t>(j));
    }
    if (cell.h * n_side_ < 1.5) {
      make_patch(cell, list);
      return;
    }
    oneapi::tbb::parallel_for(0, 4, [&](int child) { descend(child_of(cell, child), &list); });
  }

 private:
  Site site(std::size_t j) const {
    const Asperity& asperity = surface_.asperities[j];
    return {asperity.direction, asperity.radius_m / ball_.radius_m, static_cast<std::uint32_t>(j)};
  }
  bool reaches(std::size_t j, const Cap& cap) const { return elevation_at_most(site(j), cap) > 0.0; }

  void make_patch(const CubeCell& cell, const List& list) {
    std::vector<Site> sites;
    sites.reserve(list.size());
    for (const std::uint32_t j : list) sites.push_back(site(j));
    const auto index_along = [&](double x) { return static_cast<int>((x + 1.0) * 0.5 * n_side_); };
    const auto patch =
        static_cast<std::size_t>((cell.face * n_side_ + index_along(cell.b)) * n_side_ + index_along(cell.a));
    PatchBuilder(std::move(sites), patches_[patch]).build(cell);
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    progress_(static_cast<double>(++n_done_), static_cast<double>(patches_.size()));
  }

  const Ball& ball_;
  const Surface& surface_;
  int n_side_;
  std::vector<Patch>& patches_;
  const ProgressCallback& progress_;
  std::mutex mutex_;
  std::size_t n_done_ = 0;
};

}  // namespace

Envelope::Envelope(const Ball& ball, const Surface& surface, int n_threads, const ProgressCallback& progress) {
  // about 2,000 asperities to a patch: few enough to stay in the fast cache while its tree is grown
  while (6.0 * n_side_ * n_side_ * 2000.0 < static_cast<double>(surface.asperities.size())) n_side_ *= 2;
  patches_.resize(static_cast<std::size_t>(6 * n_side_ * n_side_));
  Distributor distributor(ball, surface, n_side_, patches_, progress);
  // as many workers as asked for, even where there are fewer cores
  const oneapi::tbb::global_control allow(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(n_threads));
  oneapi::tbb::task_arena arena(n_threads);
  arena.execute([&] {
    // one face after the other: the lists of one face at a time are in memory
    for (int face = 0; face < 6; ++face) distributor.descend({face, 0.0, 0.0, 1.0}, nullptr);
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
  const Patch& patch = patches_[static_cast<std::size_t>((point.face * n_side_ + ib) * n_side_ + ia)];
  const double h = 1.0 / n_side_;
  CubeCell cell{point.face, (2 * ia + 1) * h - 1.0, (2 * ib + 1) * h - 1.0, h};
  const Node* node = &patch.nodes.front();
  while (is_inner(*node) && !(static_cast<double>(node->max_elevation) < elevation)) {
    const int child = (point.a >= cell.a ? 1 : 0) + (point.b >= cell.b ? 2 : 0);
    node = &patch.nodes[node->first + static_cast<std::uint32_t>(child)];
    cell = child_of(cell, child);
  }
  const Cap cap = region_of(cell);
  Cell found{cap.centre, cap.radius, static_cast<double>(node->max_elevation), !is_inner(*node), {}, {}};
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

}  // namespace bouncelab
