// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/sim/contact.hpp"
#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

/// The ball in the plate's frame: origin at the plate's centre, z along its normal.
struct BallState {
  double x_m = 0.0, y_m = 0.0;  ///< of the centre
  double clearance_m = 0.0;     ///< z of the centre minus R: kept apart, it is micrometres at a contact
  Quaternion orientation;       ///< body -> lab
  Motion motion;
};

/// The next contact of a flight.
struct FirstContact {
  double dt_s = 0.0;           ///< from the start of the flight
  std::int64_t asperity = -1;  ///< -1: the smooth sphere
  Vector3 lever_m;             ///< r_c, from the centre to the point of contact: R A u_j - R_j e_z, or -R e_z
  BallState state;             ///< at contact, before the collision
};

/// Acceleration by the drag on a sphere, a = -kappa |v| v, kappa by the standard drag curve (drag_per_m). Neglects
/// added mass and buoyancy (1.5e-4 of gravity) and lift by spin.
Vector3 drag_acceleration_mps2(const Ball& ball, const Air& air, Vector3 velocity_mps);

/// The first instant at which the gap of any asperity, or of the smooth sphere, closes: the centre on a parabola, the
/// orientation turning with constant angular velocity (eqs. 3-5 of the paper, Rodrigues' rotation),
///
///   gap_j(t) = z_G(t) - R - R e_j(n(t)),   n(t) = -A(t)^T e_z,   e_j as in Envelope.
///
/// Method: conservative advancement. While z_G - R is above a bound of the envelope in the region around n, time goes
/// on until the bound is reached or the region left; inside a leaf it goes on by the smallest of the steps that gap_j +
/// gap_j' s - (g + R w |n'|) s^2 / 2 > 0 allows, which never passes a closing and converges quadratically.
/// @param gravity_mps2  acceleration of the centre, gravity_mps2.z < 0
/// @param left  what the ball touches at the start and must not find again while it opens (-1: the smooth sphere);
///              absent at a release
/// @param air   what slows the centre; absent: a parabola
/// Error of dt: 1e-15 s + 4 ulp(dt), plus the rounding of the gap (2e-17 m per 0.1 m of height) over the closing speed;
/// at grazing contacts, closing slower than 1e-6 m/s, the square root of that rounding counts.
/// With air, that of the integration besides, some 1e-12 s.
/// @throws InvalidArgument where gravity does not pull to the plate
FirstContact find_first_contact(const Ball& ball, const Envelope& envelope, const BallState& start,
                                Vector3 gravity_mps2, std::optional<std::int64_t> left,
                                const std::optional<Air>& air = std::nullopt);

/// The mean gradient of E(n) over the disc of this radius around a direction of the body:
///
///   1/(pi alpha^2) int grad E dA = 1/(pi alpha^2) * closed integral of E d along the circle (Gauss), d pointing
///   outwards
///
/// by 256 points of the circle: 4 um apart at 1 m/s, ten to a facet of the default ball's envelope.
/// @param n          unit vector of the body
/// @param alpha_rad  radius of the disc, in (0, 0.5)
/// Exact where one asperity is the highest on the whole disc: u_j less its part along n.
Vector3 mean_gradient(const Envelope& envelope, Vector3 n, double alpha_rad);

/// The lever of a contact on the patch that the smooth ball would have with the plate at this speed: offset by R times
/// the mean gradient of the envelope over Hertz' disc around the point of first contact, as high as the contact's own.
/// The asperities in the patch are taken as carrying the ball together, each with the area it has in the envelope.
Vector3 patch_lever_m(const Ball& ball, const Material& plate, const Envelope& envelope, const FirstContact& contact);

}  // namespace bouncelab::sim
