// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// What can be wrong with, or particular to, one impact time or one coefficient of restitution. In alphabetical
/// order, as are their words.
enum class Flag {
  by_hand,         ///< the time was set by a person
  clipped,         ///< the sound is clipped at this impact
  doubtful,        ///< the impact has more than one place where it may have been; sigma_t_s covers them
  extra_impact,    ///< the ratio of intervals is explained only by an impact that did not happen
  improbable,      ///< less likely than not to be an impact of the ball
  inferred,        ///< the impact was not detected by itself, but expected from its neighbours and then found
  missing_impact,  ///< the ratio of intervals is explained only by an impact that was not detected
  not_finite,      ///< the speed or the coefficient of restitution is missing, infinite or not a number
  overlap          ///< the next impact begins while this one still rings; the time and its standard error hold
};

/// The word of a flag in tables, `by_hand` for instance.
std::string_view name_of(Flag flag);
/// The flag of a word; absent where it is none of ours.
std::optional<Flag> flag_named(std::string_view word);

/// Flags of one row of a table, in the order in which they were set. Words of a table that are none of ours are kept
/// and written back.
class Flags {
 public:
  Flags() = default;
  Flags(std::initializer_list<Flag> flags);

  /// @param text  words joined by '|', as in a table; empty: no flag
  static Flags from_text(std::string text);
  /// The words joined by '|'; byte for byte what from_text got, then what was added.
  const std::string& text() const { return text_; }

  bool empty() const { return text_.empty(); }
  bool has(Flag flag) const;
  /// The word set first, known or not; empty where there is none.
  std::string_view first_word() const;
  /// Sets a flag at the end, unless it is set.
  void add(Flag flag);

  friend bool operator==(const Flags&, const Flags&) = default;

 private:
  std::string text_;
};

inline const std::string& cell_of(const Flags& flags) { return flags.text(); }
inline void set_cell(Flags& flags, const std::string& cell) { flags = Flags::from_text(cell); }

/// Of Onset::errors.
inline constexpr const char* kOfDigits = "digits";

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
  std::string errors = {};  ///< "digits": the standard error is that of the digits, and no more is known
  /// Where heights were measured: that which the ball fell from before this impact, and its standard error. t_s is then
  /// that of such flights without air.
  std::optional<double> fall_m = std::nullopt, sigma_fall_m = std::nullopt;
};

/// Onsets ordered by recording (in the order given), then time.
using Onsets = std::vector<Onset>;

/// The name of a recording as a table has it: ./NAME where NAME begins with = + - @ or a control character, which a
/// spreadsheet would take for a formula. It is the same file.
std::string recording_cell(const std::string& recording);
/// The column `recording` of a table of S.
template <class S>
RowColumn<S> recording_column() {
  RowColumn<S> made = column("recording", &S::recording, "File as the user named it");
  made.write = [](std::span<const S> rows) {
    std::vector<std::string> cells;
    cells.reserve(rows.size());
    for (const S& row : rows) cells.push_back(recording_cell(row.recording));
    return Column{"recording", std::move(cells)};
  };
  return made;
}

const RowColumns<Onset>& columns_of(const Onset*);
/// The `onsets` table of docs/formats.md.
Table to_table(const Onsets& onsets);
/// Columns that onsets_from_table understands; only `t_s` is required (drop 0, numbered in order, where not said).
std::vector<ColumnSpec> onset_columns();
/// @param name    of the file, for messages
/// @param before  the row before the table's first one, where the table is a piece of a longer one
/// @throws FileError naming the first row (by its line) with a number outside the range of its column, or whose time
///         does not increase in its drop
Onsets onsets_from_table(const Table& table, const std::string& name, const Onset* before = nullptr);

/// In tables of onsets and of samples the rows of a drop stand together, in the order of its impacts. One that was
/// sorted otherwise, holds rows twice, or has two balls in the order of time has wrong neighbours.
class DropsInTurn {
 public:
  /// @param table  a piece of the table, or all of it; without a column `drop` it says nothing
  /// @throws FileError naming the row, with the remedy
  void check(const Table& table, const std::string& name);

 private:
  using Drop = std::pair<std::string, std::int64_t>;  // recording and number
  std::set<Drop> done_;
  std::optional<Drop> now_;
  std::optional<std::int64_t> impact_;
};

}  // namespace bouncelab
