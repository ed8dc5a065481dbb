// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/fluctuation.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/sim/contact.hpp"
#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

// The scatter of the coefficient of restitution without simulating it: docs/physics.md, section 7, derives it. All that
// a surface, a ball and a rule of contact have to do with it is q = c s2.

/// Where a ball touches the plate beside its lowest point, in units of its radius (theta, two components), for
/// orientations at random.
struct ContactOffset {
  double variance = 0.0;      ///< s2 of each component, half the mean of theta^2
  double smooth_share = 0.0;  ///< of contacts of the smooth sphere between the asperities
};

/// Of the law's asperities at random. Their number higher than E above the sphere is a Poisson variable of mean
/// Lambda(E) = N/2 int_E^inf (r - E) p(r) dr at any place, so
///
///   s2 = int_0^inf Lambda exp(-Lambda) dE
///
/// r and E in units of the ball's radius; the smooth sphere touches with probability exp(-Lambda(0)). Closed forms
/// where asperities cover the sphere: 2/N (constant), lambda (exponential of mean lambda), (1/2) sqrt(pi w/N) (uniform
/// of width w). Relative error 1e-9, for sigma <= 1 of lognormal radii.
/// @param n_asperities  N > 0
/// @throws InvalidArgument where a parameter is out of its range
ContactOffset contact_offset(const RadiusLaw& law, double n_asperities);

/// Of one surface, drawn or measured: over n directions of a Fibonacci lattice (Gonzalez, Math. Geosci. 42, 49 (2010),
/// doi:10.1007/s11004-009-9257-x). Relative error about 2/sqrt(n), less where n is above the asperities that can touch.
/// @param envelope      of that surface
/// @param n_directions  >= 1
ContactOffset contact_offset(const Surface& surface, const Envelope& envelope, std::int64_t n_directions = 200'000);

/// c: a contact at theta has the effective mass m/(1 + c theta^2). 1/(1 + J/(m R^2)) without slip, m R^2/J without
/// friction. Coulomb friction counts as one of the two: contacts from rest stick where mu > c |theta|.
double contact_factor(const Ball& ball, const ContactModel& model);

/// Probability transform of each impact given the drop's earlier ones: uniform and independent where the theory holds.
/// @param impacts         whole drops, from the first impact on
/// @param reservoir_m2ps2 w at release, >= 0
/// @param n_threads       they take a drop each; 0: all cores
/// @return one for each impact, in [0, 1]
/// @throws InvalidArgument where an impact meets the ball on its way up, as happens to balls that spin fast
std::vector<double> probability_transforms(const Impacts& impacts, const RestitutionLaw& law, double q,
                                           double reservoir_m2ps2 = 0.0, int n_threads = 1);

}  // namespace bouncelab::sim
