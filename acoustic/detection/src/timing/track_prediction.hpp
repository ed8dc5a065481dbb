// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "timing/timed_impact.hpp"

namespace bouncelab::detection {

/// What the impacts of a track so far predict of the next one. All take the track in time order.

/// Coefficient of restitution of the next impact: the median of the last nine ratios of intervals, 0.3 ... 0.999;
/// 0.97 where there is none.
double predicted_eps(const std::vector<TimedImpact>& track);

/// How far the next interval may be from the predicted one, as a share of it: four standard deviations of the last
/// ratios (from their quartiles), within 0.015 ... 0.06.
double predicted_eps_reach(const std::vector<TimedImpact>& track);

/// The last interval; where impacts are missing in it, its last part under the predicted eps. Needs two impacts [s].
double last_flight(const std::vector<TimedImpact>& track);

/// First of n_missing + 1 intervals, a geometric series of the predicted eps, that together take total_s [s].
double first_of_missing(const std::vector<TimedImpact>& track, double n_missing, double total_s);

/// Whether an amplitude is within a factor 3.5 of what the last impacts predict: the amplitude is proportional to the
/// speed, and so to the interval before. True where fewer than four impacts are known.
bool is_predicted_amplitude(const std::vector<TimedImpact>& track, double amplitude, double interval_s);

/// Largest factor between the amplitudes of neighbours; eps and the place struck explain up to two.
inline constexpr double kMaxAmplitudeRatio = 3.5;

}  // namespace bouncelab::detection
