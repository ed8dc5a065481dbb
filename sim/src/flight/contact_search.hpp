// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bouncelab/core/elementary.hpp"
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
/// Steps are 1/128 of the time from full speed to rest under gravity, and near the summit, where the drag's |v|^1.687
/// is not smooth, a quarter of the time to it. Error at the landing: some 1e-12 m for the paper's ball.
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
                std::optional<std::int64_t> left);
  /// Second step, to be repeated until it is done: the leaf around the pole. @return whether it is found
  bool find_leaf();
  /// Third step: the contact, most often in that leaf. @throws Error where there is none
  FirstContact find_contact();

 private:
  /// The sites of a leaf that are examined: all of its list, until most of it is ruled out. Longer lists than fit are
  /// not narrowed; leaves hold so many only where as many asperities meet in a point.
  struct LeafSites {
    static constexpr std::size_t kMostNarrowed = 32;
    std::span<const std::uint16_t> list;
    bool is_narrow = false;
    std::array<std::uint16_t, kMostNarrowed> few;
    std::array<double, kMostNarrowed> gap_m, slope_mps;
  };
  struct Candidate {
    double step_s, gap_m, slope_mps;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
  };
  struct Found {
    double t_s;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
  };

  double time_of_unhindered_rise() const;
  double skip_above(double elevation, double t) const;
  void go_down_to_envelope();
  std::optional<Found> find_in_leaf(double t_exit) const;
  void leave_leaf(double t_exit);
  FirstContact contact_of(const Found& found) const;

  Candidate nearest(LeafSites& listed, double t, const Pole::Instant& pole) const;
  void narrow(LeafSites& listed, const Candidate& first, double leaf_left_s) const;
  bool is_open_until(double step_s, double gap_m, double slope_mps) const;
  Candidate judge(const Envelope::Site* site, double gap_m, double slope_mps, double t) const;
  std::int64_t index_of(const Envelope::Site* site) const;

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
