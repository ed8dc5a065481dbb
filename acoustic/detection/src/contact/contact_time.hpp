// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/band_levels.hpp"

namespace bouncelab::detection {

/// Duration of a contact at 1 m/s under one shape of the force pulse, as its square: ln P falls like (f tau)^2, so that
/// this is what a sound tells, with an error that does not depend on it; where there is little to be told it may be
/// negative.
struct ContactFit {
  double tau2_s2 = 0.0;
  double sigma2_s2 = 0.0;
  std::vector<double> log_likelihood;  ///< by band, up to constants that all pulses share
};

/// What the impacts of one drop say of their durations.
struct ContactEvidence {
  ContactFit hertz;
  ContactFit half_sine;
};

/// Duration of contact tau = tau_1 v^(-1/5) (Hertz), as the recording itself shows it.
struct ContactLaw {
  double tau_1_s = 0.0;         ///< at 1 m/s
  double sigma_s = 0.0;         ///< its standard error
  double hertz_tau_1_s = 0.0;   ///< under Hertz's pulse alone
  bool is_significant = false;  ///< the sound alone tells it, to four standard errors
};

/// How much later than the start of contact, against a wave of v^(-1/5) = reference_scaling, a wave places an impact,
/// per tau_1: the centres of the pulses coincide, their beginnings differ by half the difference of the durations,
/// (v^(-1/5) - reference_scaling) / 2.
double contact_delay(double v_mps, double reference_scaling);

/// A contact of duration tau multiplies the plate's response by P(f tau), the spectrum of its force pulse. A longer
/// contact at lower speed thus dulls the sound, which over a drop gives tau:
///
///   level_km = c_k h_m P(f_m tau_1 u_k) (1 + timbre) + noise
///
/// with a gain c_k for each impact and a response h_m for each band, by Gauss and Newton from tau_1 = 30 us (steel on
/// glass), with Hertz's pulse and with a half-sine. Each band has its own opinion of tau_1; how far they disagree
/// weighs them and gives the error, so that a mode whose level drifts with the place struck counts once and not as
/// often as it was struck. Absent where fewer than six bands tell anything.
std::optional<ContactEvidence> fit_contact(const BandLevels& levels);

/// Where the sound tells nothing of the duration: what is known of steel balls; of a ball that sounds below 3 kHz only
/// that its contact is of the order of half a period, 0 +- 1 / (2 rms_hz).
/// @param rms_hz  root mean square frequency of the wave; positive
ContactLaw assumed_contact(double rms_hz);

/// One ball, one law: the mean over drops under each pulse, and with what is known of steel balls on glass, 35 +- 20
/// us, unless the sound contradicts it; the pulse that is more likely counts, or the mean of both where the sound
/// cannot tell. Absent where there is no evidence.
std::optional<ContactLaw> pool_contacts(const std::vector<ContactEvidence>& drops);

}  // namespace bouncelab::detection
