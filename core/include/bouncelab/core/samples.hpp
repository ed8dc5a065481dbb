// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/flags.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

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
};

/// Samples ordered by recording, drop, time.
using RestitutionSamples = std::vector<RestitutionSample>;

/// The `samples` table of docs/formats.md.
Table to_table(const RestitutionSamples& samples);
/// Columns that samples_from_table understands; `v_mps` and `eps` are required.
std::vector<ColumnSpec> sample_columns();
/// Rows whose v or eps is missing or not finite stay in, flagged `not_finite`: who uses them counts them.
RestitutionSamples samples_from_table(const Table& table);

}  // namespace bouncelab
