// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/flags.hpp"
#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// One impact as detected in a recording.
struct Onset {
  std::string recording;    ///< file as named by the user
  std::int64_t drop = 0;    ///< number of the drop within the recording, from 0
  std::int64_t impact = 0;  ///< number within its drop, from 0
  double t_s = 0.0;         ///< start of contact, plus the travel time of the sound, from the recording's first sample
  std::optional<double> sigma_t_s;  ///< standard error of t_s against the other times of its drop
  std::optional<double> amplitude;  ///< peak of the impact's sound, full scale = 1
  std::optional<double> snr_db;     ///< amplitude over noise rms
  Flags flags;
  /// That it is an impact of this ball: p(drop) p(impact given the drop), 0 ... 1.
  std::optional<double> probability = std::nullopt;
};

/// Onsets ordered by recording (in the order given), then time.
using Onsets = std::vector<Onset>;

/// The name of a recording as a table has it: ./NAME where NAME begins with = + - @ or a control character, which a
/// spreadsheet would take for a formula. It is the same file.
std::string recording_cell(const std::string& recording);

/// The `onsets` table of docs/formats.md.
Table to_table(const Onsets& onsets);
/// Columns that onsets_from_table understands; only `t_s` is required (drop 0, numbered in order, where not said).
std::vector<ColumnSpec> onset_columns();
/// @param name    of the file, for messages
/// @param before  the row before the table's first one, where the table is a piece of a longer one
/// @throws FileError naming the first row (by its line) with a number outside the range of its column, or whose time
///         does not increase in its drop
Onsets onsets_from_table(const Table& table, const std::string& name, const Onset* before = nullptr);

}  // namespace bouncelab
