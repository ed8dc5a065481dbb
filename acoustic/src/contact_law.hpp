// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/acoustic/sound.hpp"
#include "impact_timing.hpp"

namespace bouncelab {

/// A timed impact whose speed is known from the flight before it, g T / 2.
struct SpeedAndTime {
  double t_s = 0.0;
  double amplitude = 0.0;
  double v_mps = 0.0;
};

/// Duration of contact tau = tau_1 v^(-1/5) (Hertz), as the recording itself shows it.
struct ContactLaw {
  double tau_1_s = 0.0;      ///< at 1 m/s
  double sigma_s = 0.0;      ///< its standard error
  double reference_u = 0.0;  ///< v^(-1/5) of the learned wave

  /// How much later than the start of contact, against the wave's own, a template places an impact: the centres of the
  /// pulses coincide, their beginnings differ by half the difference of the durations.
  double delay_s(double v_mps) const;
};

/// A contact of duration tau multiplies the plate's response by P(f tau), P(x) = cos(pi x) / (1 - 4 x^2), the spectrum
/// of a half-sine. A longer contact at lower speed thus dulls the sound; the loss over frequency between fast and slow
/// impacts gives tau. Each impact is fitted with the wave, its derivative (time) and d wave / d tau; the coefficients
/// of the latter are regressed on v^(-1/5), weighted by amplitude. Absent where they do not show tau_1 at four standard
/// errors. Source: Hertz law, doi:10.1017/CBO9781139171731; pulse of Reed, J. Phys. D 18, 2241 (1985),
/// doi:10.1088/0022-3727/18/11/011.
std::optional<ContactLaw> learn_contact_law(const Sound& sound, const ImpactWave& wave,
                                            const std::vector<SpeedAndTime>& impacts);

}  // namespace bouncelab
