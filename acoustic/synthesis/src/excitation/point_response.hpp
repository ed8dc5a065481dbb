// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "excitation/resonator_bank.hpp"

namespace bouncelab::synthesis {

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
