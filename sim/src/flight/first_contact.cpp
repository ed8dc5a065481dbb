// SPDX-License-Identifier: GPL-3.0-or-later
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/flight.hpp"
#include "flight/contact_search.hpp"
#include "flight/dragged_path.hpp"
#include "flight/parabola.hpp"

namespace bouncelab::sim {
namespace {

template <class Path>
FirstContact contact_on(Path path, const Ball& ball, const Envelope& envelope, const BallState& start,
                        std::optional<std::int64_t> left) {
  ContactSearch<Path> search(ball, envelope, start, std::move(path), left);
  while (!search.find_leaf()) {
  }
  return search.find_contact();
}

}  // namespace

FirstContact find_first_contact(const Ball& ball, const Envelope& envelope, const BallState& start,
                                Vector3 gravity_mps2, std::optional<std::int64_t> left, const std::optional<Air>& air) {
  if (!(gravity_mps2.z < 0.0))
    throw InvalidArgument("flight: gravity must pull towards the plate, its normal part is " +
                          std::to_string(gravity_mps2.z) + " m/s^2; tilt the plate less");
  if (air) return contact_on(DraggedPath(ball, *air, start, gravity_mps2), ball, envelope, start, left);
  return contact_on(Parabola(start, gravity_mps2), ball, envelope, start, left);
}

}  // namespace bouncelab::sim
