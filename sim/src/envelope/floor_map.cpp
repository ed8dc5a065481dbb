// SPDX-License-Identifier: GPL-3.0-or-later
#include "envelope/floor_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bouncelab::sim {
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
