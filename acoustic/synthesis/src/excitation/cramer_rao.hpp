// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "excitation/resonator_bank.hpp"
#include "scene/noise.hpp"

namespace bouncelab::synthesis {

/// Peak and information of the noise-free wave of one contact.
struct WaveMeasure {
  double peak = 0.0;          ///< largest |sample|
  double slope_energy = 0.0;  ///< sum over all samples of (whitened dy per sample)^2
};

/// What a noise's whitening filter makes of slopes: the filter, and its gain at each pole times s / rate.
struct Whitening {
  Whitening(const ResonatorBank& bank, const FlickerFilter& noise);

  FlickerFilter noise;
  PoleValues slope_gains;
};

/// Measures waves of one bank.
///
/// In white noise of standard deviation s per sample the time of a known wave cannot be estimated better than
///   sigma_t = s / (rate sqrt(slope_energy))     (Cramer-Rao; Kay, Estimation Theory (1993), 3.11).
/// In 1/f noise that holds for wave and noise whitened alike; s is then the standard deviation of the white noise that
/// was coloured. The whitening filter's own transient after the contact is left out: (corner / signal frequency)^2 of
/// the whole. The free ringing after the contact is summed in closed form:
///   sum_{n>=0} (Re sum_p d_p E_p^n)^2 = 1/2 Re sum_pq [ d_p d_q / (1 - E_p E_q) + d_p d_q* / (1 - E_p E_q*) ].
class WaveMeter {
 public:
  explicit WaveMeter(const ResonatorBank& bank);
  double peak(const ContactWave& wave) const;
  /// @param wave  with slopes
  WaveMeasure measure(const ContactWave& wave, const Whitening& whitening) const;

 private:
  double ringing_energy(const PoleValues& slopes) const;
  double ringing_peak(PoleValues ringing, double peak_so_far) const;

  const ResonatorBank& bank_;
  // row p, column q: what the real and the imaginary part of d_q add to those of sum_q (d_q A_pq + d_q* B_pq)
  std::vector<double> re_of_re_, re_of_im_, im_of_re_, im_of_im_;
};

}  // namespace bouncelab::synthesis
