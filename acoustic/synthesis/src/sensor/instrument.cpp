// SPDX-License-Identifier: GPL-3.0-or-later
#include "sensor/instrument.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;
constexpr double kSpeedOfSound_mps = 343.0;
constexpr double kAirDensity_kgpm3 = 1.2;

Complex pole_of(const PlateMode& mode) { return {-mode.decay_per_s, 2.0 * std::numbers::pi * mode.frequency_hz}; }

/// The sensor's own poles: the resonance, then the real one of the AC coupling.
std::vector<Complex> poles_of(const Sensor& sensor) {
  const double resonance_radps = 2.0 * std::numbers::pi * sensor.resonance_hz;
  const double damping = 0.5 / sensor.quality;
  return {resonance_radps * Complex{-damping, std::sqrt(1.0 - damping * damping)},
          -2.0 * std::numbers::pi * sensor.highpass_hz};
}

/// Residue of a transfer function with a simple zero of its denominator at s: numerator over the other factors; twice
/// where s stands for a pair.
struct Transfer {
  double resonance_radps;
  std::vector<Complex> sensor_poles;

  Complex numerator(Complex s) const { return s * s * s * resonance_radps * resonance_radps; }
  Complex at_mode(Complex s) const {
    const Complex q = sensor_poles[0], h = sensor_poles[1];
    return 2.0 * numerator(s) / ((s - std::conj(s)) * (s - q) * (s - std::conj(q)) * (s - h));
  }
  Complex at_resonance(Complex mode) const {
    const Complex q = sensor_poles[0], h = sensor_poles[1];
    return 2.0 * numerator(q) / ((q - mode) * (q - std::conj(mode)) * (q - std::conj(q)) * (q - h));
  }
  Complex at_coupling(Complex mode) const {
    const Complex q = sensor_poles[0], h = sensor_poles[1];
    return numerator(h) / ((h - mode) * (h - std::conj(mode)) * (h - q) * (h - std::conj(q)));
  }
};

std::vector<Complex> all_poles(const PlateModes& plate, const Sensor& sensor) {
  std::vector<Complex> poles;
  for (const PlateMode& mode : plate.modes()) poles.push_back(pole_of(mode));
  const std::vector<Complex> own = poles_of(sensor);
  poles.insert(poles.end(), own.begin(), own.end());
  return poles;
}

}  // namespace

Sensor piezo_sensor() { return {}; }

Sensor microphone() {
  return {SensorKind::microphone, 40.0, 20.0e3, 0.70711, {{1.9e-3, 0.4}, {4.3e-3, -0.25}, {7.8e-3, 0.2}},
          {-15.0, 0.25}};
}

namespace {

/// Modes below a frequency; at least one.
PlateModes sounding(const Ground& ground, double max_mode_hz) {
  PlateModes plate(ground, max_mode_hz);
  if (!plate.modes().empty()) return plate;
  double far_hz = max_mode_hz;  // thousands of modes lie below 200 kHz: no more of them than it takes
  std::string remedy = "; take a larger plate";
  while (far_hz < 200e3) {
    far_hz *= 2.0;
    const PlateModes more(ground, far_hz);
    if (more.modes().empty()) continue;
    remedy = "; take more than " + std::to_string(std::lround(more.modes().front().frequency_hz)) + " Hz";
    break;
  }
  throw InvalidArgument("no mode of the ground sounds below " + std::to_string(std::lround(max_mode_hz)) +
                        " Hz, the lower of max_mode_hz and half of rate_hz" + remedy);
}

}  // namespace

Instrument::Instrument(const Ground& ground, const Sensor& sensor, const std::vector<Channel>& channels, double rate_hz,
                       double max_mode_hz)
    : ground_(ground),
      sensor_(sensor),
      channels_(channels),
      plate_(sounding(ground, max_mode_hz)),
      bank_(all_poles(plate_, sensor), rate_hz),
      meter_(bank_),
      tail_(sensor.reverberation, rate_hz) {
  for (const Channel& channel : channels) couplings_.push_back(couplings(channel));
  const Transfer transfer{2.0 * std::numbers::pi * sensor.resonance_hz, poles_of(sensor)};
  sensor_residues_.resize(2);
  for (const PlateMode& mode : plate_.modes()) {
    mode_residues_.push_back(transfer.at_mode(pole_of(mode)));
    sensor_residues_[0].push_back(transfer.at_resonance(pole_of(mode)));
    sensor_residues_[1].push_back(transfer.at_coupling(pole_of(mode)));
  }
}

std::vector<Complex> Instrument::couplings(const Channel& channel) const {
  const std::size_t n = plate_.modes().size();
  std::vector<Complex> result(n);
  std::vector<double> shapes(n);
  if (sensor_.kind == SensorKind::piezo) {
    plate_.shapes_under_sensor(channel.x_m, channel.y_m, shapes);
    for (std::size_t k = 0; k < n; ++k) result[k] = channel.gain * shapes[k] / plate_.modes()[k].mass_kg;
    return result;
  }
  // Rayleigh's integral, rho/(2 pi) int phi exp(-i w (r - r_0)/c) / r dA, on a grid finer than a quarter of a wave
  constexpr int kGridX = 60, kGridY = 40;
  const double dx_m = ground_.carrier.length_x_m / kGridX, dy_m = ground_.carrier.length_y_m / kGridY;
  const double centre_m = hypot(channel.x_m, channel.y_m, channel.z_m);
  for (int i = 0; i < kGridX; ++i)
    for (int j = 0; j < kGridY; ++j) {
      const double x_m = (i - 0.5 * (kGridX - 1)) * dx_m, y_m = (j - 0.5 * (kGridY - 1)) * dy_m;
      plate_.shapes_under_ball(x_m, y_m, shapes);
      if (ground_.disk && !contains(ground_, x_m, y_m))
        for (std::size_t k = 0; k < n; ++k) shapes[k] *= plate_.modes()[k].of_disk ? 0.0 : 1.0;
      const double r_m = hypot(x_m - channel.x_m, y_m - channel.y_m, channel.z_m);
      for (std::size_t k = 0; k < n; ++k) {
        const double phase =
            2.0 * std::numbers::pi * plate_.modes()[k].frequency_hz * (r_m - centre_m) / kSpeedOfSound_mps;
        result[k] += shapes[k] / r_m * polar(1.0, -phase);
      }
    }
  for (std::size_t k = 0; k < n; ++k)
    result[k] *= channel.gain * kAirDensity_kgpm3 / (2.0 * std::numbers::pi) * dx_m * dy_m / plate_.modes()[k].mass_kg;
  return result;
}

std::vector<double> Instrument::shapes_under_ball(double x_m, double y_m) const {
  std::vector<double> shapes(plate_.modes().size());
  plate_.shapes_under_ball(x_m, y_m, shapes);
  return shapes;
}

PoleValues Instrument::amplitudes(std::size_t channel, const std::vector<double>& shapes) const {
  const std::vector<Complex>& couplings = couplings_[channel];
  const std::size_t n = shapes.size();
  PoleValues amplitudes(n + sensor_residues_.size());
  std::vector<Complex> at_sensor(sensor_residues_.size());
  for (std::size_t k = 0; k < n; ++k) {
    amplitudes.set(k, shapes[k] * couplings[k] * mode_residues_[k]);
    // off its resonance a mode responds in phase, so the real part of the coupling is used
    for (std::size_t q = 0; q < at_sensor.size(); ++q)
      at_sensor[q] += shapes[k] * couplings[k].real() * sensor_residues_[q][k];
  }
  for (std::size_t q = 0; q < at_sensor.size(); ++q) amplitudes.set(n + q, at_sensor[q]);
  return amplitudes;
}

double Instrument::travel_time_s(std::size_t channel, double x_m, double y_m) const {
  const Channel& c = channels_[channel];
  if (sensor_.kind == SensorKind::microphone) return hypot(x_m - c.x_m, y_m - c.y_m, c.z_m) / kSpeedOfSound_mps;
  return hypot(x_m - c.x_m, y_m - c.y_m) / rayleigh_speed_mps(ground_.carrier.material);
}

}  // namespace bouncelab::synthesis
