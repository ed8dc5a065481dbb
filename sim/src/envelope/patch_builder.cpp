// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/patch_builder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <utility>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace bouncelab::sim {
namespace {

std::size_t rounded_up_to(std::size_t n_bytes, std::size_t unit) { return (n_bytes + unit - 1) / unit * unit; }

}  // namespace

void* Arena::allocate(std::size_t n_bytes) {
  const std::size_t taken = rounded_up_to(n_bytes, kLine);
  const std::lock_guard lock(*mutex_);
  if (taken > block_bytes_ / 8) return add_block(taken);  // what is left of the block serves smaller ones
  if (taken > left_bytes_) {
    next_ = add_block(block_bytes_);
    left_bytes_ = block_bytes_;
  }
  std::byte* const place = next_;
  next_ += taken;
  left_bytes_ -= taken;
  return place;
}

std::byte* Arena::add_block(std::size_t n_bytes) {
  const std::size_t unit = n_bytes < kLargePage ? kLine : kLargePage;
  void* const block = std::aligned_alloc(unit, rounded_up_to(n_bytes, unit));
  if (block == nullptr) throw std::bad_alloc();
#if defined(__linux__)
  // advice: where it cannot be followed, pages are small
  if (unit == kLargePage) madvise(block, rounded_up_to(n_bytes, unit), MADV_HUGEPAGE);
#endif
  blocks_.emplace_back(block);
  return static_cast<std::byte*>(block);
}

namespace {

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

/// Does a cap around u stay outside the regions of all patches of a face, by the plane through the ball's centre and
/// the region's outermost edge? Where this is not sure it says no.
bool is_surely_outside(double along, double normal, double s, double outermost) {
  return std::abs(along) - outermost * normal > (s + 1e-6) * std::sqrt(1.0 + outermost * outermost) &&
         normal > s + 1e-3;
}

/// Calls with every patch in whose region an asperity rises above the envelope's least elevation (and a few more).
/// @param rise  of the asperity above that elevation
template <class Function>
void for_each_patch(const Asperity& asperity, double rise, int n_side, const Function& function) {
  if (rise < 0.0) return;
  // |n - u| = sqrt(2 rise) = 2 sin(angle / 2)
  const double s = std::sqrt(2.0 * rise * (1.0 - 0.5 * rise));
  const double outermost = 1.0 + (kRegionMargin - 1.0) / n_side;
  for (int face = 0; face < 6; ++face) {
    const Vector3 u = to_face(face, asperity.direction);
    if (u.x < 0.4 - s) continue;  // no region reaches farther from its face's centre than this
    if (is_surely_outside(u.y, u.x, s, outermost) || is_surely_outside(u.z, u.x, s, outermost)) continue;
    const PatchRange a = patches_met(u.y, u.x, s, n_side), b = patches_met(u.z, u.x, s, n_side);
    for (int ib = b.first; ib <= b.last; ++ib)
      for (int ia = a.first; ia <= a.last; ++ia) function(patch_index(face, ia, ib, n_side));
  }
}

}  // namespace

Distribution distribute(const Ball& ball, const Surface& surface, int n_side, double least_elevation) {
  Distribution d;
  d.begin.assign(patch_index(6, 0, 0, n_side) + 1, 0);
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

namespace {

using Node = Envelope::Node;

/// Lists up to this length are not split: shorter ones cost more memory and levels than they save comparisons.
constexpr std::size_t kListLength = 16;
/// Where more sites than kListLength meet in one point (a regular surface), splitting never ends by itself; a cell of
/// level 24 is 1e-7 wide.
constexpr std::size_t kMaxDepth = 24;
/// Sites of a leaf lie within so many of the first.
constexpr std::uint32_t kReach = 0xffffU;

constexpr std::uint32_t kNowhere = 0xffffffffU;

float rounded_up(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

}  // namespace

Envelope::Patch PatchBuilder::build(const CubeCell& cell, Arena& arena) {
  Contenders& all = levels_.front();
  given_ = all.site;
  std::iota(all.site.begin(), all.site.end(), 0U);
  place_.assign(all.size(), kNowhere);
  nodes_.assign(1, {});
  lists_.clear();
  sites_.clear();
  asperities_.clear();
  grow(0, cell, 0);
  return {arena.copy(nodes_), {}, arena.copy(sites_), arena.copy(asperities_)};
}

void PatchBuilder::grow(std::size_t node, const CubeCell& cell, std::size_t depth) {
  if (levels_.size() < depth + 2) levels_.emplace_back();
  const Region region(cell);
  Contenders& list = levels_[depth + 1];
  find_contenders_within(region, floors_.elevation_at_least(cell), levels_[depth], list, scratch_);
  elevations_at_most(region, list, scratch_.elevation);
  double top = 0.0;
  for (const double elevation : scratch_.elevation) top = std::max(top, elevation);
  nodes_[node].max_elevation = rounded_up(top);
  if (list.size() <= kListLength || depth == kMaxDepth) {
    make_leaf(nodes_[node], cell.face, list);
    return;
  }
  const std::size_t first = nodes_.size();
  nodes_[node].first = static_cast<std::uint32_t>(first);
  nodes_[node].n_list = kNoList;
  nodes_.resize(first + 4);
  for (int child = 0; child < 4; ++child)
    grow(first + static_cast<std::size_t>(child), child_of(cell, child), depth + 1);
}

void PatchBuilder::make_leaf(Node& node, int face, const Contenders& list) {
  placed_.clear();
  std::uint32_t least = kNowhere, most = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    std::uint32_t& place = place_[list.site[i]];
    if (place == kNowhere) place = add_site(face, list, i);
    placed_.push_back(place);
    least = std::min(least, place);
    most = std::max(most, place);
  }
  if (!list.site.empty() && most - least > kReach) {
    // too far apart, in a patch of more than 65,536 sites: once more, together
    for (std::size_t i = 0; i < list.size(); ++i) placed_[i] = add_site(face, list, i);
    least = placed_.front();
  }
  node.first = static_cast<std::uint32_t>(lists_.size());
  node.n_list = static_cast<std::uint32_t>(list.size());
  node.base = list.site.empty() ? 0 : least;
  for (const std::uint32_t place : placed_) lists_.push_back(static_cast<std::uint16_t>(place - node.base));
}

std::uint32_t PatchBuilder::add_site(int face, const Contenders& list, std::size_t i) {
  const auto place = static_cast<std::uint32_t>(sites_.size());
  sites_.push_back({from_face(face, {list.x[i], list.y[i], list.z[i]}), list.height[i]});
  asperities_.push_back(given_[list.site[i]]);
  return place;
}

namespace {

/// Squares of a patch: at the most 2^6 squared.
constexpr int kMaxStartDepth = 6;

/// Above it a search may take another two accesses to memory for most leaves, instead of as much memory again.
constexpr std::size_t kLarge_bytes = std::size_t{1} << 30U;

class StartWriter {
 public:
  StartWriter(const StartGrid& grid, int face, std::span<const std::uint16_t> lists, std::span<Envelope::Node> nodes,
              std::span<Envelope::Start> starts)
      : grid_(grid), face_(face), lists_(lists), nodes_(nodes), starts_(starts) {}

  /// The node covers n_side squares each way from (ia, ib) on; n_side = 0: it lies within one, whose start leads to it.
  void write(std::uint32_t number, std::uint32_t depth, int ia, int ib, int n_side) {
    Envelope::Node& node = nodes_[number];
    const bool fits = n_side > 0 && !is_inner(node) && node.n_list <= Envelope::Start::kMostListed;
    Envelope::Start start{node, depth, {}};
    if (fits) std::copy_n(lists_.begin() + node.first, node.n_list, start.list.begin());
    if (!fits && !is_inner(node)) start.node.first = node.first = keep_list(node);
    if (n_side == 1 || (n_side > 1 && !is_inner(node)))
      for (int jb = ib; jb < ib + n_side; ++jb)
        std::fill_n(starts_.begin() + static_cast<std::ptrdiff_t>(grid_.index(face_, ia, jb)), n_side, start);
    if (!is_inner(node)) return;
    const int half = n_side / 2;
    for (std::uint32_t child = 0; child < 4; ++child)
      write(node.first + child, depth + 1, ia + static_cast<int>(child & 1U) * half,
            ib + static_cast<int>(child >> 1U) * half, half);
  }

  std::vector<std::uint16_t> kept() { return std::move(kept_); }

 private:
  std::uint32_t keep_list(const Envelope::Node& node) {
    const auto begin = lists_.begin() + node.first;
    const auto first = static_cast<std::uint32_t>(kept_.size());
    kept_.insert(kept_.end(), begin, begin + node.n_list);
    return first;
  }

  const StartGrid& grid_;
  int face_;
  std::span<const std::uint16_t> lists_;
  std::span<Envelope::Node> nodes_;
  std::span<Envelope::Start> starts_;
  std::vector<std::uint16_t> kept_;
};

}  // namespace

StartGrid start_grid_for(const std::vector<Envelope::Patch>& patches, int n_side) {
  std::size_t n_leaves = 0;
  for (const Envelope::Patch& patch : patches) n_leaves += 1 + 3 * (patch.nodes.size() / 4);
  StartGrid grid{0, n_side};
  const auto is_too_coarse = [n_leaves](std::size_t n_squares) {
    const bool is_next_large = 4 * n_squares * sizeof(Envelope::Start) > kLarge_bytes;
    return (is_next_large ? 2.0 : 1.5) * static_cast<double>(n_squares) < static_cast<double>(n_leaves);
  };
  while (grid.depth < kMaxStartDepth && is_too_coarse(grid.index(6, 0, 0))) grid = {grid.depth + 1, 2 * grid.n_side};
  return grid;
}

std::vector<std::uint16_t> write_starts(const StartGrid& grid, int face, int ia, int ib,
                                        std::span<const std::uint16_t> lists, std::span<Envelope::Node> nodes,
                                        std::span<Envelope::Start> starts) {
  const int n = 1 << grid.depth;
  StartWriter writer(grid, face, lists, nodes, starts);
  writer.write(0, 0, ia * n, ib * n, n);
  return writer.kept();
}

}  // namespace bouncelab::sim
