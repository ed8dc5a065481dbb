// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace bouncelab::synthesis {

enum class SensorKind { piezo, microphone };

/// A reflection off table or wall: the impact once more, later and weaker.
struct Echo {
  double delay_s = 0.0;  ///< after the direct sound, >= 0
  double gain = 0.0;     ///< of the direct sound
};

/// The diffuse sound of a room: after the direct sound a dense tail that falls by 60 dB in `decay_60db_s`.
struct Reverberation {
  double level_db = -200.0;   ///< energy of the tail of a short sound over that of the direct sound; -200: none
  double decay_60db_s = 0.3;  ///< 0.02 to 20
};

/// From the plate's motion to voltage. Both kinds respond to acceleration (a piezo disc by inertia, sound radiated by a
/// plate in far field), through AC coupling and a resonance:
///
///   H(s) = s^2  s / (s + w_h)  w_r^2 / (s^2 + w_r s / Q + w_r^2)
///
/// A microphone receives each mode through Rayleigh's integral over the plate at the mode's frequency, and echoes.
struct Sensor {
  SensorKind kind = SensorKind::piezo;
  double highpass_hz = 150.0;    ///< > 0
  double resonance_hz = 25.0e3;  ///< > 0
  double quality = 2.0;          ///< > 0.5
  std::vector<Echo> echoes;      ///< of a microphone
  Reverberation reverberation;   ///< of a microphone's room
};

/// A bare piezo disc glued to the plate: 25 kHz, Q = 2, charge amplifier from 150 Hz.
Sensor piezo_sensor();
/// A small condenser microphone: 40 Hz to 20 kHz without a peak, three early echoes of table and
/// walls, a diffuse tail 15 dB down that lasts 0.25 s.
Sensor microphone();

/// One channel of the recording: where its sensor is. Piezos sit on the plate (z = 0), microphones above it.
struct Channel {
  double x_m = 0.115;
  double y_m = 0.065;
  double z_m = 0.0;
  double gain = 1.0;  ///< relative to the other channels; 0: dead, noise only
};

}  // namespace bouncelab::synthesis
