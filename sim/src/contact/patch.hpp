// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/ball.hpp"
#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/flight.hpp"
#include "bouncelab/sim/vector3.hpp"

namespace bouncelab::sim {

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
