// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab::fit {

/// Where the impacts were and where the sensor is: the sound of an impact arrives |r - r_sensor| / c late.
struct TravelTime {
  double wave_speed_mps = 0.0;  ///< c > 0: 2500 or so in a glass plate, 343 in air
  double sensor_x_m = 0.0, sensor_y_m = 0.0;
  /// x, y of each impact by (drop, impact), from a simulation or a camera; one recording.
  std::map<std::pair<std::int64_t, std::int64_t>, std::pair<double, double>> position_m;
};

/// Times at the plate instead of at the sensor. An onset without a position is flagged `no_position`, which breaks the
/// chain of its drop there.
/// @throws InvalidArgument where the wave speed is not positive
Onsets without_travel_time(Onsets onsets, const TravelTime& travel);

/// Columns of a table of positions: drop, impact, x_m, y_m.
std::vector<ColumnSpec> position_columns();
/// Positions from those columns; a row without numbers has no position.
TravelTime travel_time_from_table(const Table& positions, double wave_speed_mps, double sensor_x_m, double sensor_y_m);

}  // namespace bouncelab::fit
