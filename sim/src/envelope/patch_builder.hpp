// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/surface.hpp"
#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {

/// Memory for many arrays that are given back together: no room between them, and large pages where the system has
/// them, because a search reads one place in gigabytes, and would wait for the tables of small pages too.
class Arena {
 public:
  /// @param expected_bytes  roughly, of all; small arenas take no large pages
  explicit Arena(std::size_t expected_bytes = 0) : block_bytes_(std::min(kLargePage, expected_bytes + kLine)) {}

  /// Room for n values, at the start of a cache line; several threads may ask at once.
  template <class T>
  std::span<T> make(std::size_t n) {
    return {static_cast<T*>(allocate(n * sizeof(T))), n};
  }
  template <class T>
  std::span<T> copy(const std::vector<T>& values) {
    const std::span<T> copied = make<T>(values.size());
    std::uninitialized_copy(values.begin(), values.end(), copied.begin());
    return copied;
  }

 private:
  static constexpr std::size_t kLine = 64, kLargePage = std::size_t{2} << 20U;
  struct Free {
    void operator()(void* block) const { std::free(block); }
  };

  void* allocate(std::size_t n_bytes);
  std::byte* add_block(std::size_t n_bytes);

  std::size_t block_bytes_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  std::vector<std::unique_ptr<void, Free>> blocks_;
  std::byte* next_ = nullptr;
  std::size_t left_bytes_ = 0;  ///< after next_
};

/// Asperities that may be the highest somewhere in a region, in the frame of its face; by columns, because most of the
/// time of building an envelope goes on loops over them.
struct Contenders {
  std::vector<double> x, y, z;  ///< directions
  std::vector<double> height;   ///< R_j / R
  std::vector<std::uint32_t> site;

  std::size_t size() const { return site.size(); }
  void resize(std::size_t n) {
    for (std::vector<double>* column : {&x, &y, &z, &height}) column->resize(n);
    site.resize(n);
  }
  /// Contender i of another list becomes number n of this.
  void set(std::size_t n, const Contenders& from, std::size_t i) {
    x[n] = from.x[i];
    y[n] = from.y[i];
    z[n] = from.z[i];
    height[n] = from.height[i];
    site[n] = from.site[i];
  }
};

/// Columns that are worked out anew for each region.
struct ContenderScratch {
  std::vector<double> elevation;  ///< upper bounds of e(n) in the region
  std::vector<double> centre;     ///< u.X0
  std::vector<double> lead;
  std::vector<std::uint8_t> is_beaten;
};

/// Upper bounds of e(n) = height - |n - u|^2/2 over the region.
void elevations_at_most(const Region& region, const Contenders& list, std::vector<double>& elevation);

/// Reduces the list of a wider region to a region within: a superset of the contenders that are the highest somewhere
/// in it. In turn goes what stays below the floor; what one of five competitors beats everywhere in the region; in
/// short lists what any other beats. The order stays; of equal contenders the first stays.
/// @param floor   the envelope is nowhere in the region lower than this
/// @param within  result; not the same object as `wider`
void find_contenders_within(const Region& region, double floor, const Contenders& wider, Contenders& within,
                            ContenderScratch& scratch);

/// Guaranteed elevation of the envelope, by small squares of the cube's faces: makes it cheap to decide that an
/// asperity cannot touch in a region, before it is held against any other.
///
/// The highest asperity of a square q' is nowhere in a square q seen lower than height - D^2/2, D the largest distance
/// |n - u| of n in q and u in q'. The floor of q is the best such bound of the squares within two of it, over the
/// squares of this and of every coarser map (each of twice the width), so that an asperity of any size is known as far
/// as it reaches.
class FloorMap {
 public:
  /// @param margin  of the gnomonic coordinates beyond the edges of a face, >= 0
  FloorMap(const Ball& ball, const Surface& surface, double margin);

  /// E(n) is nowhere in the region of the cell lower than this; >= 0.
  double elevation_at_least(const CubeCell& cell) const;
  /// ... nowhere at all.
  double least() const { return least_; }

 private:
  double half_width_;  ///< of the map of a face, in gnomonic coordinates
  int n_side_ = 1;     ///< squares along an edge, a power of two
  std::vector<float> floors_;
  double least_ = 0.0;
};

/// Patches are ordered by face, then ib, then ia; the index of face 6 is their number.
inline std::size_t patch_index(int face, int ia, int ib, int n_side) {
  const auto n = static_cast<std::size_t>(n_side);
  return (static_cast<std::size_t>(face) * n + static_cast<std::size_t>(ib)) * n + static_cast<std::size_t>(ia);
}

/// The asperities of each patch, one patch after the other.
struct Distribution {
  std::vector<std::size_t> begin;  ///< of each patch's part of `asperities`, and the end
  std::vector<std::uint32_t> asperities;

  std::span<const std::uint32_t> of(std::size_t patch) const {
    return std::span(asperities).subspan(begin[patch], begin[patch + 1] - begin[patch]);
  }
};

/// Finds for each patch the asperities that rise in its region above the envelope's least elevation (and a few more);
/// in their order.
/// @param n_side  patches along an edge of the cube
Distribution distribute(const Ball& ball, const Surface& surface, int n_side, double least_elevation);

inline constexpr std::uint32_t kNoList = 0xffffffffU;
/// Has four children, and no list.
inline bool is_inner(const Envelope::Node& node) { return node.n_list == kNoList; }

/// Grows the quadtrees of patches, one after the other; what it works with is kept from one to the next.
class PatchBuilder {
 public:
  explicit PatchBuilder(const FloorMap& floors) : floors_(floors) {}

  /// What may touch in the patch, to be filled in before build(); `site` is the index into the surface.
  Contenders& contenders() { return levels_.front(); }

  /// @param cell   the whole patch
  /// @param arena  gets the nodes, sites and asperities; the patch has no lists yet
  Envelope::Patch build(const CubeCell& cell, Arena& arena);
  /// The lists of all leaves of the patch built last.
  const std::vector<std::uint16_t>& lists() const { return lists_; }

 private:
  void grow(std::size_t node, const CubeCell& cell, std::size_t depth);
  void make_leaf(Envelope::Node& node, int face, const Contenders& list);
  std::uint32_t add_site(int face, const Contenders& list, std::size_t i);

  const FloorMap& floors_;
  std::deque<Contenders> levels_{1};  ///< [0]: those of the patch; [1 + depth]: of the cell that is being worked on
  ContenderScratch scratch_;
  std::vector<std::uint32_t> given_;   ///< asperities by number within the patch
  std::vector<std::uint32_t> place_;   ///< in the patch's sites, by number within the patch
  std::vector<std::uint32_t> placed_;  ///< of one leaf
  std::vector<Envelope::Node> nodes_;
  std::vector<Envelope::Site> sites_;
  std::vector<std::uint32_t> asperities_;  ///< of the sites
  std::vector<std::uint16_t> lists_;
};

/// The squares at which a search may start: equal, n_side to a face's edge, ordered by face, then ib, then ia.
struct StartGrid {
  int depth = 0;   ///< below the patches
  int n_side = 1;  ///< patches' n_side 2^depth

  std::size_t index(int face, int ia, int ib) const {
    const auto n = static_cast<std::size_t>(n_side);
    return (static_cast<std::size_t>(face) * n + static_cast<std::size_t>(ib)) * n + static_cast<std::size_t>(ia);
  }
};

/// Squares enough that there are two thirds as many as leaves, or half as many where they take a gigabyte: most leaves
/// then fill a square or more.
StartGrid start_grid_for(const std::vector<Envelope::Patch>& patches, int n_side);

/// Fills in the starts of the squares of patch (ia, ib). @return the lists that they do not hold, to which the nodes
/// refer from now on
/// @param lists  of all leaves, to which the nodes refer
std::vector<std::uint16_t> write_starts(const StartGrid& grid, int face, int ia, int ib,
                                        std::span<const std::uint16_t> lists, std::span<Envelope::Node> nodes,
                                        std::span<Envelope::Start> starts);

}  // namespace bouncelab::sim
