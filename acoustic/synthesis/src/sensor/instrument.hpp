// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "bouncelab/synthesis/plate.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "excitation/point_response.hpp"
#include "excitation/resonator_bank.hpp"
#include "sensor/converter.hpp"

namespace bouncelab::synthesis {

/// Ground, sensors and converter together: how an impulse at (x, y) becomes the samples of each channel.
///
/// The transfer function from force to signal, sum_k A_k H(s) / (s^2 + 2 d_k s + w_k^2), is rational with simple poles,
/// so its response is a sum of damped sinusoids at the plate's and the sensor's poles, with residues as amplitudes.
class Instrument {
 public:
  /// @throws InvalidArgument as PlateModes and validate(Sensor) do
  Instrument(const Ground& ground, const Sensor& sensor, const std::vector<Channel>& channels, double rate_hz,
             double max_mode_hz);

  Instrument(const Instrument&) = delete;
  Instrument& operator=(const Instrument&) = delete;

  const ResonatorBank& bank() const { return bank_; }
  const WaveMeter& meter() const { return meter_; }
  const ReverberationTail& tail() const { return tail_; }
  const PlateModes& plate() const { return plate_; }
  std::size_t n_channels() const { return channels_.size(); }

  /// Values of the mode shapes under the ball.
  std::vector<double> shapes_under_ball(double x_m, double y_m) const;
  /// Amplitude at each pole in one channel of a unit impulse where the mode shapes have these values.
  PoleValues amplitudes(std::size_t channel, const std::vector<double>& shapes) const;
  /// From the point of contact to the sensor: by Rayleigh's wave in the plate, or by air to a microphone.
  double travel_time_s(std::size_t channel, double x_m, double y_m) const;

 private:
  using Complex = std::complex<double>;
  std::vector<Complex> couplings(const Channel& channel) const;

  Ground ground_;
  Sensor sensor_;
  std::vector<Channel> channels_;
  PlateModes plate_;
  ResonatorBank bank_;
  WaveMeter meter_;
  ReverberationTail tail_;
  std::vector<std::vector<Complex>> couplings_;  // by channel and mode: of the mode's motion to the sensor, over mass
  std::vector<Complex> mode_residues_;           // by mode: at its own pole, for unit coupling
  std::vector<std::vector<Complex>> sensor_residues_;  // by pole of the sensor and mode
};

}  // namespace bouncelab::synthesis
