// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "delay/impact_timer.hpp"
#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// What one search needs: the sound and the template with the impacts known so far.
struct Search {
  WhiteSound& white;
  const ImpactTemplate& learned;
  ImpactTimer timer;
  double template_s = 0.0;  ///< duration of the template
};

/// A track while it is being timed.
struct TimedTrack {
  Search search;
  std::vector<TimedImpact> impacts;
};

/// Adds an impact to the track; its ringing is subtracted from then on.
void append(TimedTrack& track, const TimedImpact& impact);

/// The most likely impact within reach_s of t_s. A window that begins after an impact misses its strongest part, so
/// that a wide search takes several windows.
ImpactFit find_impact(Search& search, double t_s, double reach_s, double until_s);

/// Step of a search that is wider than the template [s]: a quarter of it.
double search_step_s(const Search& search);

/// What the impacts of a track so far predict of the next one. All take the track in time order.

/// Coefficient of restitution of the next impact: the median of the last nine ratios of intervals, 0.3 ... 0.999;
/// 0.97 where there is none.
double predicted_eps(const std::vector<TimedImpact>& track);

/// How far the next interval may be from the predicted one, as a share of it: four standard deviations of the last
/// ratios (from their quartiles), within 0.015 ... 0.06.
double predicted_eps_reach(const std::vector<TimedImpact>& track);

/// An impact to come.
struct PredictedImpact {
  double t_s = 0.0;
  double flight_s = 0.0;  ///< before it
  double spread_s = 0.0;  ///< of the predictions about their median, at most
};

/// The impact after the next `n_left_out`, by the predicted eps: the median of what the last impact, the one before it
/// and the one before that predict, each with the flight that ends there: one of them may be in a wrong place. Needs
/// two impacts.
PredictedImpact predict_beyond_end(const std::vector<TimedImpact>& track, int n_left_out);

/// First of n_missing + 1 intervals, a geometric series of the predicted eps, that together take total_s [s].
double first_of_missing(const std::vector<TimedImpact>& track, double n_missing, double total_s);

}  // namespace bouncelab::detection
