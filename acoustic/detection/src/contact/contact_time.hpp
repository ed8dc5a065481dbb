// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// Amplitude of each band of the template in each of a drop's impacts.
struct BandLevels {
  std::vector<double> f_hz;                ///< centroid of each band's energy
  std::vector<double> noise2;              ///< variance that noise adds to a level, by band
  std::vector<double> contact_scaling;     ///< v^(-1/5), by impact
  std::vector<std::vector<double>> level;  ///< by impact and band, in units of the template
};

/// Levels of up to sixty bands, each the projection of the sound on the template, of at most 192 impacts. Left out are
/// bands with less energy than half of their neighbours, which hold the skirts of others' modes, bands in which the
/// template itself is mostly noise, and impacts slower than an eighth of the fastest. The own noise of an impact that
/// the template was estimated from is in the template too; its contribution is subtracted.
/// @param impacts  with known speeds
BandLevels measure_levels(WhiteSound& white, const ImpactTemplate& learned, const std::vector<TimedImpact>& impacts);

/// Duration of contact at 1 m/s under one shape of the force pulse, as its square: ln P is linear in (f tau)^2 for
/// small f tau, so that tau^2 is estimated with an error that does not depend on it; it may be negative where the error
/// is large.
struct ContactFit {
  double tau2_s2 = 0.0;
  double sigma2_s2 = 0.0;              ///< standard error of tau2_s2
  std::vector<double> log_likelihood;  ///< by band, up to constants that all pulses share
};

/// Contact time by the impacts of one drop.
struct ContactEvidence {
  ContactFit hertz;
  ContactFit half_sine;
};

/// Duration of contact tau = tau_1 v^(-1/5) (Hertz).
struct ContactLaw {
  double tau_1_s = 0.0;         ///< at 1 m/s
  double sigma_s = 0.0;         ///< its standard error
  double hertz_tau_1_s = 0.0;   ///< under Hertz's pulse alone
  bool is_significant = false;  ///< the recording alone gives it at four standard errors
};

/// How much later than the start of contact a template of scaling v^(-1/5) = reference_scaling places an impact, per
/// tau_1: the centres of the pulses coincide, their beginnings differ by half the difference of the durations,
/// (v^(-1/5) - reference_scaling) / 2.
double contact_delay(double v_mps, double reference_scaling);

/// tau_1 of one drop from its band levels. A contact of duration tau multiplies the plate's response by P(f tau), the
/// spectrum of its force pulse, so that longer contacts at lower speeds lower the high bands:
///
///   level_km = c_k h_m P(f_m tau_1 u_k) (1 + scatter) + noise,   u_k = v_k^(-1/5)
///
/// with an amplitude c_k for each impact and a response h_m for each band, by Gauss-Newton steps from
/// tau_1 = 30 us (steel on glass), with Hertz's pulse and with a half-sine. tau_1 is estimated per band and pooled; the
/// between-band scatter sets weights and error, so that a mode whose level drifts with the place struck counts once and
/// not once an impact. Absent with fewer than eight impacts or six usable bands.
std::optional<ContactEvidence> fit_contact(const BandLevels& levels);

/// The contact law that the frequencies of a sound suggest: (0.4 +- 0.25) / rms_hz, since a pulse of force of duration
/// tau has the rms frequency 1 / (2 tau) and what it strikes answers to a part of it.
/// @param rms_hz  root mean square frequency of the impacts as recorded (recorded_rms_frequency); positive
ContactLaw assumed_contact(double rms_hz);

/// One ball, one law: the weighted mean over drops under each pulse, combined with the assumed one, unless the two
/// differ by more than three standard errors; then the mean of the two pulses, weighted by their probabilities. The
/// assumed one where there is no evidence.
ContactLaw pool_contacts(const std::vector<ContactEvidence>& drops, const ContactLaw& assumed);

}  // namespace bouncelab::detection
