// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/flight.hpp"
#include "bouncelab/sim/vector3.hpp"
#include "envelope/cube_cell.hpp"

namespace bouncelab::sim {

/// The centre's way without air.
class Parabola {
 public:
  Parabola(const BallState& start, Vector3 gravity_mps2)
      : y0_m_(start.clearance_m), v0_mps_(start.motion.velocity_mps.z), gravity_mps2_(gravity_mps2) {}

  double initial_velocity_mps() const { return v0_mps_; }
  /// Bound of the downward acceleration.
  double bend_mps2() const { return -gravity_mps2_.z; }
  double height_m(double t_s) const { return y0_m_ + t_s * (v0_mps_ - 0.5 * bend_mps2() * t_s); }
  double velocity_mps(double t_s) const { return v0_mps_ - bend_mps2() * t_s; }
  /// The last time at which the centre is at `level`; t where it is below already.
  double descent_to(double level_m, double t_s) const {
    const double y = height_m(t_s), v = velocity_mps(t_s), g = bend_mps2();
    if (y <= level_m) return t_s;
    const double root = std::sqrt(v * v + 2.0 * g * (y - level_m));
    return t_s + (v > 0.0 ? (v + root) / g : 2.0 * (y - level_m) / (root - v));
  }

  /// Place and velocity of the centre at t, from those at the start.
  void move(double t_s, BallState& state) const {
    const Vector3 v = state.motion.velocity_mps, g = gravity_mps2_;
    state.x_m += t_s * (v.x + 0.5 * g.x * t_s);
    state.y_m += t_s * (v.y + 0.5 * g.y * t_s);
    state.clearance_m += t_s * (v.z + 0.5 * g.z * t_s);
    state.motion.velocity_mps = v + t_s * g;
  }

 private:
  double y0_m_, v0_mps_;
  Vector3 gravity_mps2_;
};

/// The centre's way through air, from the start to below the plate. Integrated by the classical Runge-Kutta rule of
/// fourth order, read off between the steps by quintic Hermite polynomials, which match place, velocity and
/// acceleration at both ends.
///
/// Steps are 1/32 of the time from full speed to rest under gravity, and near the summit, where the drag's |v|^1.681 is
/// not smooth, a quarter of the time to it: 92 in all. Error at the landing at 1.4 m/s: 2e-13 m for the paper's ball,
/// 6e-12 m (4 ps) for one of table tennis.
class DraggedPath {
 public:
  DraggedPath(const Ball& ball, const Air& air, const BallState& start, Vector3 gravity_mps2);

  double height_m(double t_s) const { return at(t_s).place_m.z; }
  double velocity_mps(double t_s) const { return at(t_s).velocity_mps.z; }
  /// The last time at which the centre is at `level`; t where it is below already.
  double descent_to(double level_m, double t_s) const;
  double initial_velocity_mps() const { return nodes_.front().velocity_mps.z; }
  /// Bound of the downward acceleration.
  double bend_mps2() const { return bend_mps2_; }

  /// Place (z: the clearance), velocity and acceleration of the centre.
  struct Node {
    double t_s;
    Vector3 place_m, velocity_mps, acceleration_mps2;
  };
  Node at(double t_s) const;

  /// Place and velocity of the centre at t.
  void move(double t_s, BallState& state) const;

 private:
  std::vector<Node> nodes_;
  double bend_mps2_;
};

/// The body-fixed direction that points at the plate, n(t) = -A(t)^T e_z. Angular velocity is constant in the lab,
/// hence in the body too, and n runs on a circle: n' = n x Omega, Omega = A^T omega.
struct Pole {
  Vector3 along, cosine, sine;  ///< n = along + cosine cos(rate t) + sine sin(rate t)
  double rate_radps = 0.0;      ///< |Omega|
  double speed_radps = 0.0;     ///< |n'|, constant

  struct Instant {
    Vector3 direction, velocity;
  };
  Instant at(double t_s) const {
    const auto [c, s] = turn(rate_radps * t_s);
    return {along + c * cosine + s * sine, (rate_radps * c) * sine - (rate_radps * s) * cosine};
  }

  /// n at t = 0.
  Vector3 direction() const { return along + cosine; }

  /// The same motion with its clock set back to 0 at t.
  Pole from(double t_s) const {
    const auto [c, s] = turn(rate_radps * t_s);
    return {along, c * cosine + s * sine, c * sine - s * cosine, rate_radps, speed_radps};
  }

 private:
  struct Turn {
    double cosine, sine;
  };
  static Turn turn(double angle) {
    if (angle > 0.01) {
      const SinCos exact = sin_cos(angle);
      return {exact.cos, exact.sin};
    }
    // the next terms of the series are below 2e-18
    const double a2 = angle * angle;
    return {1.0 - a2 * (0.5 - a2 * (1.0 / 24.0 - a2 * (1.0 / 720.0))),
            angle * (1.0 - a2 * (1.0 / 6.0 - a2 * (1.0 / 120.0)))};
  }
};

inline Pole make_pole(Quaternion orientation, Vector3 spin_radps) {
  const Quaternion to_body = conjugate(orientation);
  const Vector3 n = -rotate(to_body, {0, 0, 1});
  const double rate = norm(spin_radps);
  if (rate == 0.0) return {{}, n, {}, 0.0, 0.0};
  const Vector3 axis = normalized(rotate(to_body, spin_radps));
  const Vector3 along = dot(axis, n) * axis;
  const Vector3 sine = cross(n, axis);
  return {along, n - along, sine, rate, rate * norm(sine)};
}

/// How long gap + slope s - bend s^2/2 stays positive, for gap >= 0.
inline double safe_step_s(double gap_m, double slope_mps, double bend_mps2) {
  const double root = std::sqrt(slope_mps * slope_mps + 2.0 * bend_mps2 * gap_m);
  return slope_mps > 0.0 ? (slope_mps + root) / bend_mps2 : 2.0 * gap_m / (root - slope_mps);
}

/// A bound of the envelope is passed by when the ball is higher by this: far below what matters (femtoseconds),
/// far above the rounding of heights.
inline constexpr double kClear_m = 1e-12;
/// Cells after which a search is given up: only an invalid state gets there.
inline constexpr int kMaxSearchSteps = 10'000'000;

/// The search for the first contact of one flight (the method: find_first_contact). Path is the centre's: Parabola or
/// DraggedPath.
///
/// It goes in steps, each of which ends by asking for the memory that the next reads. Of a large envelope that takes as
/// long as all the computing; where the searches of several balls take turns, none waits.
template <class Path>
class ContactSearch {
 public:
  /// First step: where the pole is when the ball comes down. @param envelope  must outlive the search
  ContactSearch(const Ball& ball, const Envelope& envelope, const BallState& start, Path path,
                std::optional<std::int64_t> left)
      : radius_m_(ball.radius_m),
        envelope_(&envelope),
        start_(start),
        path_(std::move(path)),
        pole_(make_pole(start.orientation, start.motion.spin_radps)),
        bend_mps2_(path_.bend_mps2() + radius_m_ * pole_.rate_radps * pole_.speed_radps),
        left_(left) {
    t_ = time_of_unhindered_rise();
    go_down_to_envelope();
  }

  /// Second step, to be repeated until it is done: the leaf around the pole. @return whether it is found
  bool find_leaf() {
    const std::optional<Envelope::Leaf> found = leaf_search_->advance();
    if (found) leaf_ = *found;
    return found.has_value();
  }

  /// Third step: the contact, most often in that leaf. @throws Error where there is none
  FirstContact find_contact() {
    for (int step = 0; step < kMaxSearchSteps; ++step) {
      // most often the leaf under the pole is where the ball comes down
      const double t_exit = t_ + leaf_.margin_rad / pole_.speed_radps;
      if (const auto found = find_in_leaf(t_exit)) return contact_of(*found);
      leave_leaf(t_exit);
      go_down_to_envelope();
      while (!find_leaf()) {
      }
    }
    throw Error("flight: no contact found in " + std::to_string(kMaxSearchSteps) +
                " cells of the surface; is the spin or the speed absurd?");
  }

 private:
  struct Candidate {
    double step_s, gap_m, slope_mps;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
  };
  struct Found {
    double t_s;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
  };

  /// The envelope follows the pole no faster than R |n'| sqrt(2 max E): a ball that rises faster leaves all behind.
  double time_of_unhindered_rise() const {
    const double chase_mps = radius_m_ * pole_.speed_radps * std::sqrt(2.0 * envelope_->max_elevation());
    if (!left_) return 0.0;
    return std::max(0.0, (path_.initial_velocity_mps() - chase_mps) / path_.bend_mps2());
  }

  double skip_above(double elevation, double t) const {
    const double level_m = radius_m_ * elevation;
    return path_.height_m(t) > level_m + kClear_m ? path_.descent_to(level_m, t) : t;
  }

  void go_down_to_envelope() {
    t_ = skip_above(envelope_->max_elevation(), t_);
    here_ = pole_.from(t_);
    leaf_search_.emplace(*envelope_, here_.direction());
  }

  /// After a leaf without a contact.
  void leave_leaf(double t_exit) {
    if (skip_above(leaf_.max_elevation, t_) < t_exit) {
      t_ = t_exit;
      return;
    }
    // stay in the widest cell that the ball is above; the leaf itself at the least
    const Envelope::Cell cell = envelope_->cell_below((path_.height_m(t_) - kClear_m) / radius_m_, here_.direction());
    t_ = std::max(t_exit, std::min(t_ + cell.margin_rad / pole_.speed_radps, skip_above(cell.max_elevation, t_)));
  }

  FirstContact contact_of(const Found& found) const {
    const double t = found.t_s;
    FirstContact contact{t, index_of(found.site), {0.0, 0.0, -radius_m_}, start_};
    path_.move(t, contact.state);
    contact.state.orientation = normalized(rotation_by(t * start_.motion.spin_radps) * start_.orientation);
    if (found.site != nullptr)
      contact.lever_m = radius_m_ * (rotate(contact.state.orientation, found.site->direction) -
                                     Vector3{0.0, 0.0, found.site->height});
    return contact;
  }

  /// Advances from t_ to t_exit through the leaf; what is hit, if anything.
  std::optional<Found> find_in_leaf(double t_exit) const {
    double t = skip_above(leaf_.max_elevation, t_);
    while (t < t_exit) {
      const Candidate first = nearest(t, here_.at(t - t_));
      const double resolution_s = 1e-15 + 4.0 * std::numeric_limits<double>::epsilon() * t;
      // after a safe step the gap is at most bend step^2: what is left is that over the closing speed
      const double left_s = bend_mps2_ * first.step_s * first.step_s / -first.slope_mps;
      if (first.slope_mps < 0.0 && left_s <= resolution_s) return Found{t + first.step_s, first.site};
      t += std::max(first.step_s, resolution_s);
      if (path_.height_m(t) > radius_m_ * leaf_.max_elevation + kClear_m)
        t = std::max(t, std::min(t_exit, skip_above(leaf_.max_elevation, t)));
    }
    return std::nullopt;
  }

  /// The smallest safe step of all that can touch.
  Candidate nearest(double t, const Pole::Instant& pole) const {
    const double y = path_.height_m(t), v = path_.velocity_mps(t);
    Candidate first = judge(nullptr, y, v, t);
    for (const std::uint16_t k : leaf_.list) {
      const Envelope::Site& site = leaf_.sites[k];
      const double gap = y - radius_m_ * (site.height - 0.5 * norm2(pole.direction - site.direction));
      const double slope = v - radius_m_ * dot(site.direction, pole.velocity);
      if (is_open_until(first.step_s, gap, slope)) continue;
      const Candidate candidate = judge(&site, gap, slope, t);
      if (candidate.step_s < first.step_s) first = candidate;
    }
    return first;
  }

  bool is_open_until(double step_s, double gap_m, double slope_mps) const {
    return gap_m > 0.0 && gap_m + step_s * (slope_mps - 0.5 * bend_mps2_ * step_s) >= 0.0;
  }

  Candidate judge(const Envelope::Site* site, double gap_m, double slope_mps, double t) const {
    const double bend = site == nullptr ? path_.bend_mps2() : bend_mps2_;
    // what was just left opens with the contact's speed: its gap cannot close before 2 slope / bend
    if (t == 0.0 && slope_mps > 0.0 && left_ == index_of(site)) return {slope_mps / bend, gap_m, slope_mps, site};
    if (gap_m > 0.0) return {safe_step_s(gap_m, slope_mps, bend), gap_m, slope_mps, site};
    if (slope_mps < 0.0) return {0.0, gap_m, slope_mps, site};
    return {2.0 * slope_mps / bend, gap_m, slope_mps, site};
  }

  /// Index into the surface; -1 for nullptr, the smooth sphere.
  std::int64_t index_of(const Envelope::Site* site) const {
    return site == nullptr ? -1 : std::int64_t{leaf_.asperities[static_cast<std::size_t>(site - leaf_.sites.data())]};
  }

  double radius_m_;
  const Envelope* envelope_;
  BallState start_;
  Path path_;
  Pole pole_;
  double bend_mps2_;  ///< bound of -gap'' for asperities
  std::optional<std::int64_t> left_;

  double t_ = 0.0;  ///< until here there is no contact
  Pole here_;       ///< with its clock at t_
  std::optional<LeafSearch> leaf_search_;
  Envelope::Leaf leaf_{};  ///< around the pole
};

}  // namespace bouncelab::sim
