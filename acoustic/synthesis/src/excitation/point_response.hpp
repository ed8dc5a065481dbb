// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "excitation/resonator_bank.hpp"
#include "scene/background.hpp"

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

/// Waves of many contacts at one point, from one wave that is computed once: that of a unit impulse.
///
///   y(n) = integral K(n - a - u) force(u) du,   K(t) = sum_g kappa(4 t - g) K(g / 4)
///
/// K is stored at quarters of a sample. It is band-limited (ConverterFilter), so kappa, Kaiser's windowed sinc of 16
/// quarters, leaves 3e-8 of the peak; with the force as point impulses w_q at u_q the sum over both is one short
/// filter, F(m) = sum_q w_q kappa(m - 4 (a + u_q)), y(n) = sum_m F(m) K(n - m / 4). Free ringing is the same sum over
/// exponentials.
class PointResponse {
 public:
  /// The longest contact whose wave this gives.
  static constexpr double kLongestContact_samples = 64.0;

  /// @param bank        must outlive this
  /// @param amplitudes  of the point, by pole
  PointResponse(const ResonatorBank& bank, const PoleValues& amplitudes);

  /// As bank.wave(contact, amplitudes, with_slopes), within 3e-8 of the peak; up to the longest contact.
  ContactWave wave(const Contact& contact, bool with_slopes) const;

 private:
  static constexpr int kPhases = 4;  // of K in a sample
  using Rows = std::array<std::vector<double>, kPhases>;
  struct Filter {
    std::int64_t first = 0;  // m of taps[0]
    std::vector<double> taps;
  };

  void tabulate(const PoleValues& amplitudes);
  void bound_later_values();
  static Filter filter_of(const Contact& contact);
  static std::vector<double> filtered(const Filter& filter, const Rows& rows, std::int64_t first, std::size_t n);
  PoleValues ringing(const Filter& filter, std::int64_t from_quarter) const;
  std::optional<double> peak(const Filter& filter, const ContactWave& wave) const;

  const ResonatorBank& bank_;
  Rows values_, slopes_;                  // K and dK/dt at kFirst + k + phase / 4
  PoleValues quarter_step_;               // exp(s / 4)
  std::array<PoleValues, kPhases> free_;  // a_p z_p of the unit impulse at kFree + phase / 4
  std::vector<double> bounds_;            // [k] of |K| from kFree + k blocks on
};

}  // namespace bouncelab::synthesis
