// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace bouncelab {

/// Force of an elastic Hertz contact over its duration: s in [0, 1] is time over contact time, the integral is 1.
///
///   F(s) ~ x^(3/2),   x'' = -(5/4) x^(3/2)  in the time unit (largest indentation)/v
///
/// The shape is universal: material, radius and speed only scale it (Johnson, Contact Mechanics (1985), 11.4). It
/// starts like s^(3/2), softer than the half-sine often used, which matters for a picker that looks at the first
/// samples.
double hertz_force(double s);

/// Point impulses that stand for a force pulse: at node_q of its duration, with weight_q; total weight 1.
struct PointImpulses {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// The pulse of a contact as point impulses whose spectrum is the pulse's own, within 1e-9, up to half the sample rate.
///
/// The nodes are equally spaced in theta, s = (1 - cos theta)/2: there the force times ds/dtheta, continued evenly and
/// periodically, is smooth to the ninth derivative, so that the trapezoidal rule converges like n^-10 once n exceeds
/// the phase that passes during the contact.
/// @param duration_samples  of the contact, in (0, kMaxContact_samples]
PointImpulses hertz_impulses(double duration_samples);
inline constexpr double kMaxContact_samples = 1600.0;

}  // namespace bouncelab
