// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bouncelab/core/numerics.hpp"
#include "sensor/converter.hpp"

namespace bouncelab::synthesis {

/// One complex value for each pole of a bank.
template <class T>
struct PoleValuesOf {
  std::vector<T> re, im;

  explicit PoleValuesOf(std::size_t n = 0) : re(n, T{}), im(n, T{}) {}
  std::size_t size() const { return re.size(); }
  std::complex<T> operator[](std::size_t k) const { return {re[k], im[k]}; }
  void set(std::size_t k, std::complex<T> value) {
    re[k] = value.real();
    im[k] = value.imag();
  }
};

using PoleValues = PoleValuesOf<double>;

/// A contact as seen by one sensor, in samples.
struct Contact {
  double arrival_samples = 0.0;   ///< begin of the force pulse plus travel time
  double duration_samples = 0.0;  ///< of the contact, > 0
  double impulse = 0.0;           ///< integral of the force
};

/// The wave of one contact until it rings freely.
struct ContactWave {
  std::int64_t first = 0;       ///< frame of samples[0], at or before the wave begins
  std::vector<double> samples;  ///< y
  std::vector<double> slopes;   ///< dy per sample; empty unless asked for
  PoleValues ringing;           ///< a_p z_p at frame end(), a multiple of ResonatorBank::kBlock
  std::optional<double> peak;   ///< largest |y|, also after end(), where it comes with the samples

  std::int64_t end() const { return first + static_cast<std::int64_t>(samples.size()); }
};

/// Damped resonators driven by band-limited force pulses, exact in continuous time.
///
///   y(t) = Re sum_p a_p z_p(t),   z_p' = s_p z_p + g(t),   g = force convolved with h (ConverterFilter)
///
/// Over one sample interval z_p advances by its exact propagator exp(s_p dt) plus the integral of exp(s_p (t_{n+1} -
/// u)) g(u) by Gauss-Legendre quadrature. h has compact support: g vanishes W samples before and after the pulse, and
/// from there on the wave is a pure sum of decaying sinusoids, whatever number of contacts in one state. Error below
/// 1e-8 of the peak.
class ResonatorBank {
 public:
  /// Free ringing is rendered in blocks of this many frames.
  static constexpr std::int64_t kBlock = 64;

  /// @param poles  s_p in 1/s, real part < 0, imaginary part >= 0 (0: a real pole)
  ResonatorBank(std::vector<std::complex<double>> poles, double rate_hz);

  std::size_t size() const { return poles_.size(); }
  const std::vector<std::complex<double>>& poles_per_s() const { return poles_; }
  double rate_hz() const { return rate_hz_; }
  const ConverterFilter& filter() const { return filter_; }
  /// After this many frames the slowest resonator has decayed by 1e-11.
  std::int64_t memory_frames() const { return memory_frames_; }

  ContactWave wave(const Contact& contact, const PoleValues& amplitudes, bool with_slopes) const;
  /// Adds free ringing to `out` (a multiple of kBlock frames) and advances the state to its end. Four neighbours that
  /// are all below `silence` at a block's begin are set to zero.
  void ring(PoleValues& state, double silence, std::span<double> out) const;
  /// The same; the sound, not the state, is in single precision: 3e-7 of each resonator's amplitude.
  void ring(PoleValues& state, double silence, std::span<float> out) const;
  /// State after n_frames of free ringing.
  void advance(PoleValues& state, std::int64_t n_frames) const;
  /// The same for less than a block, from a table.
  void advance_in_block(PoleValues& state, std::int64_t n_frames) const;

 private:
  template <class T>
  void ring_together(PoleValues& state, double silence, const PoleValuesOf<T>& waves, std::span<T> out) const;
  /// g at frames first + fraction, first + fraction + 1 ...
  std::vector<double> force(const Contact& contact, std::int64_t first, std::size_t n_frames, double fraction) const;

  std::vector<std::complex<double>> poles_;
  double rate_hz_;
  std::int64_t memory_frames_;
  ConverterFilter filter_;
  QuadratureRule interval_;       // nodes within one sample interval
  PoleValues pole_steps_;         // s / rate
  PoleValues step_, block_step_;  // exp(s / rate), exp(s kBlock / rate)
  std::vector<PoleValues> kick_;  // by node: weight exp(s (1 - node) / rate)
  PoleValues waves_;              // kBlock values for each pole: exp(s j / rate); zeros make up whole fours
  PoleValuesOf<float> single_waves_;
};

}  // namespace bouncelab::synthesis
