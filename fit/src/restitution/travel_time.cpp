// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/travel_time.hpp"

#include <cmath>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::fit {

Onsets without_travel_time(Onsets onsets, const TravelTime& travel) {
  if (!(travel.wave_speed_mps > 0.0) || !std::isfinite(travel.wave_speed_mps))
    throw InvalidArgument("speed of the sound " + std::to_string(travel.wave_speed_mps) + " m/s: must be positive");
  for (Onset& onset : onsets) {
    const auto found = travel.position_m.find({onset.drop, onset.impact});
    if (found == travel.position_m.end()) {
      onset.flags.add(Flag::no_position);
      continue;
    }
    const auto& [x_m, y_m] = found->second;
    onset.t_s -= hypot(x_m - travel.sensor_x_m, y_m - travel.sensor_y_m) / travel.wave_speed_mps;
  }
  return onsets;
}

std::vector<ColumnSpec> position_columns() {
  constexpr Range kPlates_m{-1e3, 1e3};
  return {{"drop", ColumnType::integer, true, kIndexRange},
          {"impact", ColumnType::integer, true, kIndexRange},
          {"x_m", ColumnType::real, true, kPlates_m},
          {"y_m", ColumnType::real, true, kPlates_m}};
}

TravelTime travel_time_from_table(const Table& positions, double wave_speed_mps, double sensor_x_m, double sensor_y_m) {
  TravelTime travel{wave_speed_mps, sensor_x_m, sensor_y_m, {}};
  const auto &drops = *positions.integers("drop"), &impacts = *positions.integers("impact");
  const auto &x = *positions.reals("x_m"), &y = *positions.reals("y_m");
  for (std::size_t k = 0; k < positions.n_rows(); ++k)
    if (std::isfinite(x[k]) && std::isfinite(y[k])) travel.position_m[{drops[k], impacts[k]}] = {x[k], y[k]};
  return travel;
}

}  // namespace bouncelab::fit
