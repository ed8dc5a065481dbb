// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// Samples of impact 1 of nearly one speed. The flight before them was launched by impact 0, the first of the drop.
struct FirstFlights {
  double v_mps = 0.0, eps = 0.0;  ///< of one of them, g T/2 and T'/T
  RestitutionSamples samples;
};

/// Of all samples of impact 1, those within a hundredth together: the height over v^2 is one for them.
std::vector<FirstFlights> first_flights(const RestitutionSamples& samples);

/// The speed of the impact that they began with, nearly: by the eps of the impact that ended them.
double speed_of_first_impact(const FirstFlights& flights);

/// Logarithm of the height of release. The launch u follows from the flight, the speed of
/// impact 0 is w = u/eps, and a fall through the air from the height lands with it.
/// @param eps  of impact 0
double ln_release_height(const FirstFlights& flights, const OneAirAndContact& one, double eps);

/// Heights of the drops of one speed. @param ln_height  that of `flights.v_mps`
void add_heights(const FirstFlights& flights, const Estimate& ln_height, std::vector<ReleaseHeight>& heights);

/// The rule of the named ball's sport, and the speed with which it falls; absent where no sample is nearly so fast, or
/// none so slow: in speed a twentieth, in height a tenth, over which eps hardly changes.
std::optional<Rebound> rebound_within(const RestitutionSamples& samples, const AirAndContact& known);

}  // namespace bouncelab::fit
