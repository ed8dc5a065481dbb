// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "delay/timed_impact.hpp"
#include "model_number.hpp"
#include "template/impact_template.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {

/// The numbers of the contact time (docs/detector.md, "Start of contact").
struct ContactModel {
  // A pulse of duration tau, half a sine, has the rms frequency 1/(2 tau). What is struck, the room and the microphone
  // pass the higher frequencies better or worse: of steel, wood and rubber from 30 us to 6 ms, tau f is between 0.1 and
  // 0.8.
  double duration_times_frequency = 0.4;
  double duration_sigma = 0.25;  ///< of it
  double most_difference = 3.0;  ///< standard errors between that and a recording, beyond which it is dropped
  double significant = 2.0;      ///< standard errors of tau^2: four of tau

  /// Of a duration, since the pulse may not be Hertz's: half a sine of 0.87 times its length has about its spectrum.
  double shape_sigma = 0.07;

  // levels of impacts in bands
  std::size_t fewest_impacts = 8;
  std::size_t fewest_bands = 6;
  std::size_t most_bands = 60;
  std::size_t fewest_bins = 6;        ///< a band holds a mode and not a part of one
  std::size_t neighbours = 4;         ///< bands on either side that are smoothed over
  double least_template_snr = 300.0;  ///< energy of the template over that of the noise left in it
  double most_argument = 1.25;  ///< f tau: there P = 0.25, and near its first zero the model of the pulse does not hold
  double least_scatter = 0.01;  ///< less than any ball has
  double huber = 2.5;           ///< Huber's threshold [standard deviations]
};

BOUNCELAB_MODEL ContactModel kContact;

/// Spectrum P(x) of the force pulse of an elastic sphere on a half-space (Johnson, Contact Mechanics (1985), 11.4)
/// about its middle, x = frequency times duration, P(0) = 1. The sound of an impact is that of an impulse multiplied by
/// it: longer contacts have less at high frequencies.
struct PulseSpectrum {
  double value = 0.0;
  double slope = 0.0;
};
/// P(x) and P'(x) for x >= 0, by cubic interpolation: to 1e-6. Beyond x = 4 both are 0.
PulseSpectrum pulse_spectrum(double x);

/// Amplitude of each band of the template in each of a drop's impacts.
struct BandLevels {
  std::vector<double> f_hz;                ///< centroid of each band's energy
  std::vector<double> noise2;              ///< variance that noise adds to a level, by band
  std::vector<double> contact_scaling;     ///< v^(-1/5), by impact
  std::vector<std::vector<double>> level;  ///< by impact and band, in units of the template
};

/// Levels of up to sixty bands, each the projection of the sound on the template. Left out are bands with less energy
/// than half of their neighbours, which hold the skirts of others' modes, and those in which noise is a part of the
/// template.
/// @param impacts  with known speeds
BandLevels measure_levels(WhiteSound& white, const ImpactTemplate& learned, const std::vector<TimedImpact>& impacts);

/// Duration of contact at 1 m/s by the impacts of one drop, as its square: ln P is linear in (f tau)^2 for small f tau,
/// so that tau^2 is estimated with an error that does not depend on it; it may be negative where the error is large.
struct ContactFit {
  double tau2_s2 = 0.0;
  double sigma2_s2 = 0.0;  ///< standard error of tau2_s2
};

/// Duration of contact tau = tau_1 v^(-1/5) (Hertz).
struct ContactLaw {
  double tau_1_s = 0.0;         ///< at 1 m/s
  double sigma_s = 0.0;         ///< its standard error for a Hertzian pulse
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
/// with an amplitude c_k for each impact and a response h_m for each band: a Gauss-Newton fit with variances of scatter
/// and noise, Huber's weights, and c_k and h_m removed by two-way demeaning. Only bands in which P is at least 0.25 at
/// all impacts count; the fit begins at the longest contact that leaves six bands, since from short ones it may end
/// where the bands lie in the side lobes of the pulse. The scatter between bands sets the error, so that a mode whose
/// level drifts with the place struck counts once and not once an impact. Absent with fewer than eight impacts or six
/// such bands, or where they tell less of the contact time than that it is a ball's.
/// @param levels  of bands in the order of their frequencies
std::optional<ContactFit> fit_contact(const BandLevels& levels);

/// The contact law that the frequencies of a sound suggest: (0.4 +- 0.25) / rms_hz, since a pulse of force of duration
/// tau has the rms frequency 1 / (2 tau) and what it strikes answers to a part of it.
/// @param rms_hz  root mean square frequency of the impacts as recorded (recorded_rms_frequency); positive
ContactLaw assumed_contact(double rms_hz);

/// One ball, one law: the weighted mean over drops, combined with the assumed one, unless the two differ by more than
/// three standard errors. The assumed one where there is no drop.
ContactLaw pool_contacts(const std::vector<ContactFit>& drops, const ContactLaw& assumed);

}  // namespace bouncelab::detection
