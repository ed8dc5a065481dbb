// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/start_writer.hpp"

#include <algorithm>
#include <utility>

#include "envelope/patch_builder.hpp"

namespace bouncelab::sim {
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
