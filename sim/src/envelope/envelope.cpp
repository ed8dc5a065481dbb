// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/envelope.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "envelope/cube_cell.hpp"
#include "envelope/patch_builder.hpp"

namespace bouncelab::sim {
namespace {

void fill(Contenders& contenders, const Ball& ball, const Surface& surface, std::span<const std::uint32_t> asperities,
          int face) {
  contenders.resize(asperities.size());
  for (std::size_t i = 0; i < asperities.size(); ++i) {
    const Asperity& asperity = surface.asperities[asperities[i]];
    const Vector3 u = to_face(face, asperity.direction);
    contenders.x[i] = u.x;
    contenders.y[i] = u.y;
    contenders.z[i] = u.z;
    contenders.height[i] = asperity.radius_m / ball.radius_m;
    contenders.site[i] = asperities[i];
  }
}

}  // namespace

Envelope::Envelope(const Ball& ball, const Surface& surface, int n_threads, const ProgressCallback& progress) {
  // 600 to 2,500 asperities to a patch: few enough to stay in the fast cache while its tree is grown
  while (6.0 * n_side_ * n_side_ * 2500.0 < static_cast<double>(surface.asperities.size())) n_side_ *= 2;
  patches_.resize(patch_index(6, 0, 0, n_side_));
  const auto n_row = static_cast<std::size_t>(n_side_);
  // about what constant radii need, the most of all
  arena_ = std::make_shared<Arena>(80 * surface.asperities.size());
  std::vector<std::vector<std::uint16_t>> lists(patches_.size());
  const auto for_each_row = [&](const auto& function) {
    parallel_for(6 * n_row, n_threads,
                 [&](std::size_t row) { function(static_cast<int>(row / n_row), static_cast<int>(row % n_row)); });
  };
  {
    const FloorMap floors(ball, surface, (kRegionMargin - 1.0) / n_side_);
    const Distribution distribution = distribute(ball, surface, n_side_, floors.least());
    std::mutex mutex;
    std::size_t n_done = 0;
    for_each_row([&](int face, int ib) {
      PatchBuilder builder(floors);
      for (int ia = 0; ia < n_side_; ++ia) {
        const std::size_t place = patch_index(face, ia, ib, n_side_);
        fill(builder.contenders(), ball, surface, distribution.of(place), face);
        patches_[place] = builder.build(cell_of_square(face, ia, ib, n_side_), *arena_);
        lists[place] = builder.lists();
      }
      if (!progress) return;
      const std::lock_guard lock(mutex);
      progress(static_cast<double>(n_done += n_row), static_cast<double>(patches_.size()));
    });
  }
  const StartGrid grid = start_grid_for(patches_, n_side_);
  start_depth_ = grid.depth;
  starts_ = arena_->make<Start>(grid.index(6, 0, 0));
  for_each_row([&](int face, int ib) {
    for (int ia = 0; ia < n_side_; ++ia) {
      const std::size_t place = patch_index(face, ia, ib, n_side_);
      const auto all = std::exchange(lists[place], {});
      patches_[place].lists = arena_->copy(write_starts(grid, face, ia, ib, all, patches_[place].nodes, starts_));
    }
  });
  for (const Patch& patch : patches_)
    max_elevation_ = std::max(max_elevation_, static_cast<double>(patch.nodes.front().max_elevation));
}

Envelope::Leaf Envelope::leaf_at(Vector3 n) const {
  LeafSearch search(*this, n);
  for (;;)
    if (const auto leaf = search.advance()) return *leaf;
}

Envelope::Cell Envelope::cell_below(double elevation, Vector3 n) const {
  const CubePoint point = cube_point(n);
  const int ia = square_of(point.a, n_side_), ib = square_of(point.b, n_side_);
  const Patch& patch = patches_[patch_index(point.face, ia, ib, n_side_)];
  Way way{patch.nodes.front(), cell_of_square(point.face, ia, ib, n_side_)};
  while (is_inner(way.node) && !(static_cast<double>(way.node.max_elevation) < elevation)) way.descend(patch, point);
  return way.found(point);
}

Envelope::Support Envelope::support(Vector3 n) const {
  const Leaf leaf = leaf_at(n);
  Support support;
  for (const std::uint16_t k : leaf.list) {
    const Site& site = leaf.sites[k];
    const double elevation = site.height - 0.5 * norm2(n - site.direction);
    if (elevation > support.elevation) support = {elevation, leaf.asperities[k]};
  }
  return support;
}

LeafSearch::LeafSearch(const Envelope& envelope, Vector3 n) : envelope_(&envelope), point_(cube_point(n)) {
  const int depth = envelope.start_depth_;
  const StartGrid grid{depth, envelope.n_side_ << depth};
  ia_ = square_of(point_.a, grid.n_side);
  ib_ = square_of(point_.b, grid.n_side);
  start_ = &envelope.starts_[grid.index(point_.face, ia_, ib_)];
  patch_ = &envelope.patches_[patch_index(point_.face, ia_ >> depth, ib_ >> depth, envelope.n_side_)];
  __builtin_prefetch(start_);
  __builtin_prefetch(patch_);
}

std::optional<Envelope::Leaf> LeafSearch::advance() {
  if (next_ == Next::start) {
    const int depth = static_cast<int>(start_->depth), shift = envelope_->start_depth_ - depth;
    way_ = {start_->node, cell_of_square(point_.face, ia_ >> shift, ib_ >> shift, envelope_->n_side_ << depth)};
    if (start_->node.n_list <= Envelope::Start::kMostListed) {
      list_ = start_->list.data();
      next_ = Next::list;
    }
  } else if (next_ == Next::node) {
    way_.descend(*patch_, point_);
  }
  if (next_ == Next::list) {
    // here: gcc 12 takes a function that does nothing but this for one without effect, and calls to it out
    const Envelope::Leaf leaf{way_.found(point_), std::span(list_, way_.node.n_list),
                              patch_->sites.subspan(way_.node.base), patch_->asperities.subspan(way_.node.base)};
    for (const std::uint16_t k : leaf.list) __builtin_prefetch(&leaf.sites[k]);
    for (const std::uint16_t k : leaf.list) __builtin_prefetch(&leaf.asperities[k]);
    return leaf;
  }
  if (is_inner(way_.node)) {
    next_ = Next::node;
    __builtin_prefetch(&way_.next(*patch_, point_));
  } else {
    next_ = Next::list;
    list_ = patch_->lists.data() + way_.node.first;
    __builtin_prefetch(list_);
    if (way_.node.n_list > 0) __builtin_prefetch(list_ + way_.node.n_list - 1);
  }
  return std::nullopt;
}

}  // namespace bouncelab::sim
