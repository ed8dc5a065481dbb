// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// Amplitude of each band of the template in each of a drop's impacts.
struct BandLevels {
  std::vector<double> f_hz;                ///< centroid of each band's energy
  std::vector<double> noise2;              ///< variance that noise adds to a level, by band
  std::vector<double> contact_scaling;     ///< v^(-1/5), by impact
  std::vector<std::vector<double>> level;  ///< by impact and band, in units of the template
};

/// Levels of up to sixty bands, each the projection of the sound on the template, of at most 192 impacts. Left out are
/// bands with less energy than half of their neighbours, which hold the skirts of others' modes, bands in which the
/// template itself is mostly noise, and impacts slower than an eighth of the fastest. The own noise of an impact that
/// the template was estimated from is in the template too; its contribution is subtracted.
/// @param impacts  with known speeds
BandLevels measure_levels(WhiteSound& white, const ImpactTemplate& learned, const std::vector<TimedImpact>& impacts);

}  // namespace bouncelab::detection
