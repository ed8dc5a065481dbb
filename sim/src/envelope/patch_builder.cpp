// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/patch_builder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace bouncelab::sim {
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

}  // namespace bouncelab::sim
