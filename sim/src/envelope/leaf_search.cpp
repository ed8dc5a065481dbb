// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/leaf_search.hpp"

#include <span>

#include "envelope/distribution.hpp"
#include "envelope/patch_builder.hpp"
#include "envelope/start_writer.hpp"

namespace bouncelab::sim {
namespace {

/// Asks the processor to load early what lies anywhere in memory.
void prefetch(const void* place) {
#if defined(__GNUC__)
  __builtin_prefetch(place);
#else
  (void)place;
#endif
}

}  // namespace

LeafSearch::LeafSearch(const Envelope& envelope, Vector3 n) : envelope_(&envelope), point_(cube_point(n)) {
  const int depth = envelope.start_depth_;
  const StartGrid grid{depth, envelope.n_side_ << depth};
  ia_ = square_of(point_.a, grid.n_side);
  ib_ = square_of(point_.b, grid.n_side);
  start_ = &envelope.starts_[grid.index(point_.face, ia_, ib_)];
  patch_ = &envelope.patches_[patch_index(point_.face, ia_ >> depth, ib_ >> depth, envelope.n_side_)];
  prefetch(start_);
  prefetch(patch_);
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
    for (const std::uint16_t k : leaf.list) prefetch(&leaf.sites[k]);
    for (const std::uint16_t k : leaf.list) prefetch(&leaf.asperities[k]);
    return leaf;
  }
  if (is_inner(way_.node)) {
    next_ = Next::node;
    prefetch(&way_.next(*patch_, point_));
  } else {
    next_ = Next::list;
    list_ = patch_->lists.data() + way_.node.first;
    prefetch(list_);
    if (way_.node.n_list > 0) prefetch(list_ + way_.node.n_list - 1);
  }
  return std::nullopt;
}

}  // namespace bouncelab::sim
