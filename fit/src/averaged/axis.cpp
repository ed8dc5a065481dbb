// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged/axis.hpp"

#include <cmath>

namespace bouncelab::fit {
namespace {

FinePlace fine_place(const Axis& axis, std::size_t k, double s) {
  double w[] = {s * (-0.5 + s * (1.0 - 0.5 * s)), 1.0 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2.0 - 1.5 * s)),
                s * s * (-0.5 + 0.5 * s)};
  // beyond the ends the parabola of the last three goes on
  std::size_t first = k - 1;
  if (k == 0) {
    const double beyond = w[0];
    w[0] = w[1] + 3.0 * beyond, w[1] = w[2] - 3.0 * beyond, w[2] = w[3] + beyond, w[3] = 0.0;
    first = 0;
  } else if (k + 2 == axis.at.size()) {
    w[2] += 3.0 * w[3], w[1] -= 3.0 * w[3], w[0] += w[3], w[3] = 0.0;
  }
  FinePlace place{axis.at[k] + s * axis.distance(), {}, k, k + 1};
  for (std::size_t j = 0; j < 4; ++j)
    if (first + j < axis.at.size() && w[j] != 0.0) place.neighbours.emplace_back(first + j, w[j]);
  return place;
}
}  // namespace

Axis axis_of(double prior_sd, double middle, double reach) {
  if (!(prior_sd > 0.0)) return {{0.0}, 0.0};
  const std::size_t n = 2 * static_cast<std::size_t>(std::ceil(reach / kApart)) + 1;
  Axis axis{{}, prior_sd};
  for (std::size_t k = 0; k < n; ++k)
    axis.at.push_back(middle + reach * (2.0 * static_cast<double>(k) / static_cast<double>(n - 1) - 1.0));
  return axis;
}

std::vector<FinePlace> finer(const Axis& axis) {
  if (axis.at.size() == 1) return {{axis.at[0], {{0, 1.0}}, 0, 0}};
  std::vector<FinePlace> places;
  for (std::size_t k = 0; k + 1 < axis.at.size(); ++k)
    for (std::size_t j = 0; j < kFiner; ++j)
      places.push_back(fine_place(axis, k, (static_cast<double>(j) + 0.5) / kFiner));
  return places;
}

}  // namespace bouncelab::fit
