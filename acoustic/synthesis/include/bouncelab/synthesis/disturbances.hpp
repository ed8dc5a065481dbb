// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::synthesis {

/// Sounds and interference of a laboratory beside the ball. All off by default. Levels are in units of the clean peak
/// of the weakest wanted impact, so that 1 is as loud as the weakest impact to be detected.
struct Disturbances {
  double hum_level = 0.0;     ///< amplitude of the mains' fundamental; harmonics 2 to 7 fall like 1/n
  double hum_hz = 50.0;       ///< > 0
  double drift_level = 0.0;   ///< slow wander of the zero line, periods 2 to 15 s
  double clicks_per_s = 0.0;  ///< electric clicks two samples long, levels 0.3 to 5, Poisson in time
  double knocks_per_s = 0.0;  ///< a second, softer object strikes the plate, levels about 0.5 to 4, Poisson in time
  double double_hit_fraction = 0.0;  ///< in [0, 1]: share of impacts followed by a knock after 1.5 to 12 ms
  bool robot_cycle = false;    ///< release click; in each pause fan, pick-up tick and motor bursts; needs pause_s >= 2
  double timbre_wander = 0.0;  ///< standard deviation of ln(mode amplitude) from impact to impact
  double phase_wander_rad = 0.0;  ///< standard deviation of the modes' phases from impact to impact
};

}  // namespace bouncelab::synthesis
