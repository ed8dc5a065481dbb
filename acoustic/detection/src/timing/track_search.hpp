// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/dsp/white_window.hpp"
#include "timing/impact_template.hpp"
#include "timing/impact_timer.hpp"
#include "timing/timed_impact.hpp"

namespace bouncelab::detection {

/// What one search needs: the sound and the template with the impacts known so far.
struct Search {
  audio::WhiteSound& white;
  const ImpactTemplate& learned;
  ImpactTimer timer;
  double template_s = 0.0;  ///< duration of the template
};

/// A track while it is being timed.
struct TimedTrack {
  Search search;
  std::vector<TimedImpact> impacts;
  std::vector<double> own_shares;  ///< what impacts that sound alone have of their own, over what the template explains
};

/// Adds an impact to the track; its ringing is subtracted from then on.
void append(TimedTrack& track, const TimedImpact& impact);

/// The most likely impact within reach_s of t_s. A window that begins after an impact misses its strongest part, so
/// that a wide search takes several windows.
ImpactFit find_impact(Search& search, double t_s, double reach_s, double until_s);

/// Step of a search that is wider than the template [s]: a quarter of it.
double search_step_s(const Search& search);

}  // namespace bouncelab::detection
