// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/acoustic/sound.hpp"
#include "impact_wave.hpp"

namespace bouncelab {

/// A timed impact whose speed is known from the flight before it, g T / 2.
struct SpeedAndTime {
  double t_s = 0.0;
  double amplitude = 0.0;  ///< in units of the wave
  double v_mps = 0.0;
};

/// tau_1 = duration of a contact at 1 m/s, under one shape of the force pulse.
struct ContactFit {
  double tau_1_s = 0.0;
  double sigma_s = 0.0;
  std::vector<double> log_misfit;  ///< log of what is left of each stack of impacts
};

/// What the impacts of one drop say of their durations.
struct ContactEvidence {
  ContactFit hertz;
  ContactFit half_sine;
  double reference_u = 0.0;  ///< v^(-1/5) of the learned wave
};

/// Duration of contact tau = tau_1 v^(-1/5) (Hertz), as the recording itself shows it.
struct ContactLaw {
  double tau_1_s = 0.0;  ///< at 1 m/s
  double sigma_s = 0.0;  ///< its standard error
};

/// How much later than the start of contact, against the wave's own, a wave places an impact, per tau_1: the centres of
/// the pulses coincide, their beginnings differ by half the difference of the durations, (v^(-1/5) - reference_u) / 2.
double contact_delay(double v_mps, double reference_u);

/// A contact of duration tau multiplies the plate's response by P(f tau), the spectrum of its force pulse. A longer
/// contact at lower speed thus dulls the sound, which over a drop gives tau: the response H(f) and tau_1 are fitted to
/// all impacts together, A_k H(f) P(f tau_1 v_k^(-1/5)), by Gauss and Newton from tau_1 = 30 us (steel on glass), with
/// Hertz's pulse and with a half-sine. Impacts are stacked with their neighbours in speed. Absent where there are fewer
/// than eight.
std::optional<ContactEvidence> learn_contact(const Sound& sound, const ImpactWave& wave,
                                             const std::vector<SpeedAndTime>& impacts);

/// One ball, one law: the mean over drops under each pulse; the pulse that fits better counts, or the mean of both
/// where the sound cannot tell. Absent where tau_1 is not known to four standard errors.
std::optional<ContactLaw> pool_contacts(const std::vector<ContactEvidence>& drops);

}  // namespace bouncelab
