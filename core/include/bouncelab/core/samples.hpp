// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// What a coefficient of restitution was computed with. Numbers that are absent are not known.
struct SampleConditions {
  // not in the intervals, because they were taken out or there were none:
  bool drag_corrected = false;
  bool contact_time_corrected = false;
  bool travel_time_corrected = false;    ///< of the sound, from impact to sensor
  std::optional<double> gravity_mps2;    ///< of the speeds
  std::optional<Ball> ball;              ///< whose drag and contact time the fit takes
  std::optional<Material> plate;         ///< likewise
  std::optional<double> air_kgpm3;       ///< density of the air; absent: that of a room
  std::optional<double> wave_speed_mps;  ///< of the sound, for the travel time
  bool of_heights = false;               ///< v and eps are roots of heights, not of intervals
  bool sigma_is_least = false;           ///< standard errors are of the digits alone

  /// By times or heights; else speeds and coefficients were measured as they are.
  bool of_flights() const { return gravity_mps2.has_value(); }

  friend bool operator==(const SampleConditions&, const SampleConditions&) = default;
};

/// One measured coefficient of restitution.
struct RestitutionSample {
  std::string recording;              ///< file of the recording, as named by the user
  std::int64_t drop = 0;              ///< number of the drop within the recording
  std::int64_t impact = 0;            ///< number of the impact within its drop
  double t_s = 0.0;                   ///< time of the impact
  double v_mps = 0.0;                 ///< normal impact speed, g T / 2
  double eps = 0.0;                   ///< coefficient of restitution; may exceed 1, never clamped
  std::optional<double> sigma_v_mps;  ///< standard error of v
  std::optional<double> sigma_eps;    ///< standard error of eps from the timing alone; absent = not known
  Flags flags;                        ///< the fit leaves out a sample that has any
  SampleConditions conditions;
};

/// Samples ordered by recording, drop, time.
using RestitutionSamples = std::vector<RestitutionSample>;

const RowColumns<RestitutionSample>& columns_of(const RestitutionSample*);
/// The `samples` table of docs/formats.md.
Table to_table(std::span<const RestitutionSample> samples);
/// `samples` as those of this ball on this plate, as far as they are given: where a table does not say so itself.
void name_ball(RestitutionSamples& samples, const std::optional<Ball>& ball, const std::optional<Material>& plate);
/// Columns that samples_from_table understands; `v_mps` and `eps` are required.
std::vector<ColumnSpec> sample_columns();
/// Rows whose v or eps is missing or not finite stay in, flagged `not_finite`: who uses them counts them.
/// @param name  of the file, for messages
/// @throws FileError naming the first row with a number outside the range of its column: a negative standard error,
///         or a speed above 1e4 m/s or eps outside [-1000, 1000] in a row without a flag, for instance
RestitutionSamples samples_from_table(const Table& table, const std::string& name);

}  // namespace bouncelab
