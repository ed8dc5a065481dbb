// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

/// A deviation from the medians: kappa exp(ln_kappa), tau exp(ln_tau).
struct Deviation {
  double ln_kappa = 0.0, ln_tau = 0.0;
};

/// What is known beforehand of the drag on a ball and of how long it touches the plate: ln kappa and ln tau are normal.
/// (docs/physics.md, section 9)
struct AirAndContact {
  std::string name;  ///< of the ball; empty: any other one
  double gravity_mps2 = kDefaultGravity_mps2;
  std::optional<Ball> ball;  ///< drag by the standard curve; absent: kappa is constant
  Air air;
  double kappa_per_m = 0.0;   ///< median, of a ball without size
  double kappa_spread = 0.0;  ///< standard deviation of ln kappa, 0 where there is no drag
  ContactDuration contact;    ///< median, and the standard deviation of ln tau; 0 s: contacts are instantaneous
  bool has_drag = true, has_contact = true;
  bool of_heights = false;  ///< the samples are, in place of intervals
  bool is_named = true;     ///< false: what may be of a ball that is not named
  double ln_share = 0.0;    ///< logarithm of what it counts beforehand
  double most_eps = 1.0;    ///< such a ball has about this on the hardest floor

  bool is_open() const { return has_drag || has_contact; }
};

/// Its median at 1 m/s.
double kappa_at_1_mps(const AirAndContact& known);

/// Of these samples: their first one speaks for all. Of a ball that is not named nothing is known.
AirAndContact air_and_contact_of(const RestitutionSamples& samples);

/// What may be of these samples, each narrow enough to be linear: the ball that is named; else those that people drop,
/// one of a simulation, with neither air nor contact time, and any other, heavy or light.
std::vector<AirAndContact> places_of(const RestitutionSamples& samples);

/// The shortest interval between impacts that samples are made of.
double shortest_interval_s(const RestitutionSamples& samples, double gravity_mps2);

/// eps at the plate and the speed there, of what the intervals are without drag and contact: v = g T/2, eps = T'/T.
struct AtThePlate {
  double v_mps = 0.0, eps = 0.0;
  double stretch = 1.0;  ///< d eps / d (T'/T): of errors, and of the density of T'/T
};

/// One of the deviations.
class OneAirAndContact {
 public:
  /// @param known  must outlive this
  OneAirAndContact(const AirAndContact& known, Deviation deviation);
  /// @param from_height  the speed is that of a fall without drag, not of an interval
  AtThePlate at_the_plate(double v_mps, double eps, bool from_height) const;
  /// The flight before an impact. @param v_mps  g T/2. @param eps  of the impact that the flight began with
  Flight flight_before(double v_mps, double eps) const;
  /// The height of a release at rest, from the speed at the plate.
  double fall_height_m(double speed_mps) const;
  double fall_mps(double height_m) const;
  double rise_height_m(double launch_mps) const;

 private:
  double kappa_per_m(double v_mps) const;
  double contact_s(double v_mps) const;

  const AirAndContact& known_;
  double kappa_factor_, tau_factor_;
};

/// The samples as they are at the plate.
RestitutionSamples at_the_plate(RestitutionSamples samples, const AirAndContact& known, Deviation deviation);

}  // namespace bouncelab::fit
