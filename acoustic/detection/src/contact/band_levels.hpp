// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "timing/impact_template.hpp"

namespace bouncelab::detection {

/// A timed impact whose speed is known from the flight before it, g T / 2.
struct SpeedAndTime {
  double t_s = 0.0;
  double amplitude = 0.0;  ///< in units of the wave
  double v_mps = 0.0;
};

/// How loud each band of the learned wave is in each of a drop's impacts.
struct BandLevels {
  std::vector<double> f_hz;                ///< middle of each band's energy
  std::vector<double> noise2;              ///< variance that noise adds to a level, by band
  std::vector<double> contact_scaling;     ///< v^(-1/5), by impact
  std::vector<std::vector<double>> level;  ///< by impact and band, in units of the wave
};

/// Levels of up to sixty bands in which the wave has its modes, each the part of the sound that is the wave's, of at
/// most 192 impacts. Bands that are quieter than half of their neighbours are left out, since they hold the skirts of
/// others' modes, and bands in which the wave itself is mostly noise. An impact that the wave was learned from finds
/// its own noise there again; so much is taken off.
BandLevels read_levels(const audio::AudioSource& sound, const ImpactTemplate& wave,
                       const std::vector<SpeedAndTime>& impacts);

}  // namespace bouncelab::detection
