// SPDX-License-Identifier: GPL-3.0-or-later
// Which columns or rows of other people's tables are read, and what their numbers may be.
#include <algorithm>
#include <cmath>
#include <utility>

#include "bouncelab/core/numerics.hpp"
#include "tables/foreign_columns.hpp"

namespace bouncelab {

bool rises(const Sequence& sequence) {
  if (sequence.values.empty()) return false;
  constexpr std::size_t kLeast = 3;
  std::size_t n = 1;
  for (std::size_t k = 1; k < sequence.values.size(); ++k) {
    const NumberCell* before = sequence.before(k);
    if (before && sequence.values[k].number.value >= before->value) {
      ++n;
      continue;
    }
    if (before && (n < kLeast || sequence.has_drops)) return false;
    n = 1;
  }
  return sequence.has_drops || sequence.values.back().part > 0 || n >= kLeast || n == sequence.values.size();
}

bool has_equal_steps(const Sequence& sequence) {
  const auto& values = sequence.values;
  if (values.size() < 3) return false;
  const double step = values[1].number.value - values[0].number.value;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (std::abs(values[k].number.value - values[k - 1].number.value - step) >
        0.1 * step + 2.0 * (values[k - 1].number.rounding + values[k].number.rounding))
      return false;
  return step > 0.0;
}

bool goes_up_and_down(const Sequence& sequence) {
  constexpr std::size_t kRun = 3;
  std::size_t up = 0, down = 0, most_up = 0, most_down = 0;
  for (std::size_t k = 1; k < sequence.values.size(); ++k) {
    const double here = sequence.values[k].number.value, before = sequence.values[k - 1].number.value;
    up = here > before ? up + 1 : 0;
    down = here < before ? down + 1 : 0;
    most_up = std::max(most_up, up), most_down = std::max(most_down, down);
  }
  return most_up >= kRun && most_down >= kRun;
}

TitleUnit unit_called(const std::string& name) {
  return unit_of_title("x (" + name + ")").value_or(TitleUnit{Dimension::speed, 0.0, name, {}});
}

double typical_interval(const Sequence& sequence, bool intervals) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const NumberCell* before = sequence.before(k);
    const double length = sequence.values[k].number.value - (before && !intervals ? before->value : 0.0);
    if (length > 0.0 && (intervals || before)) lengths.push_back(length);
  }
  return lengths.empty() ? 0.0 : median(std::move(lengths));
}

bool is_speed_of_a_ball(double v_mps) {
  constexpr double kSlowest_mps = 0.02, kFastest_mps = 30.0;
  return v_mps >= kSlowest_mps && v_mps <= kFastest_mps;
}

bool are_of_a_ball(const Sequence& sequence, const std::string& as, double si) {
  if (as == "heights") {
    constexpr double kLeast_m = 0.05, kMost_m = 4.0;
    const double height_m = si * sequence.values.front().number.value;
    return height_m > kLeast_m && height_m < kMost_m;
  }
  constexpr double kGravity_mps2 = 9.81;
  return is_speed_of_a_ball(0.5 * kGravity_mps2 * si * typical_interval(sequence, as == "intervals"));
}

std::vector<Reading> readings_of(const Sequence& sequence, const std::vector<const char*>& as, bool has_unit,
                                 const ForeignOptions& options, const std::string& key_columns) {
  std::vector<Reading> readings;
  const bool are_positive = std::all_of(sequence.values.begin(), sequence.values.end(),
                                        [](const Sequence::Value& value) { return value.number.value > 0.0; });
  for (const char* unit : {"s", "ms", "us", "m", "cm", "mm"})
    for (const char* one : as) {
      const TitleUnit known = unit_called(unit);
      if ((known.dimension == Dimension::length) != (std::string(one) == "heights")) continue;
      if (has_unit ? known.si == 1.0 : (are_positive || *one == 't') && are_of_a_ball(sequence, one, known.si))
        readings.push_back({std::string(one) + " in " + (has_unit ? sequence.unit->name : unit),
                            {one, has_unit ? options.unit : unit, key_columns}});
    }
  return readings;
}

namespace {

/// Does every part rise, or every part fall, over three numbers or more?
bool goes_one_way(const Sequence& sequence) {
  std::size_t n_up = 0, n_down = 0, n = 0, n_parts = 0;
  for (std::size_t k = 0; k < sequence.values.size(); ++k) {
    const NumberCell* before = sequence.before(k);
    ++(before ? n : n_parts);
    n_up += before && sequence.values[k].number.value > before->value ? 1 : 0;
    n_down += before && sequence.values[k].number.value < before->value ? 1 : 0;
  }
  return n > n_parts && (n == n_up || n == n_down);
}

/// --columns with these columns, and what was told of drops.
std::string with_drops(const ForeignTable& table, const Selection& selection) {
  std::string text = columns_option(table, selection.key(), selection.columns);
  for (const std::string_view part : cells_of(table.options.columns, ','))
    if (part.starts_with("drop=")) text += "," + std::string(part);
  return text;
}

/// A column's numbers as far as they are numbers.
Sequence glance_at(const ForeignTable& table, const Selection& selection) {
  Sequence sequence;
  const std::size_t n = selection.columns.size();
  for (std::size_t k = 0; k < n * table.rows.size(); ++k) {
    const std::size_t row = selection.by_rows ? k / n : k % table.rows.size(),
                      column = selection.by_rows ? k % n : k / table.rows.size();
    if (const auto number = table.number(table.rows[row], selection.columns[column]))
      sequence.values.push_back({*number, row, static_cast<std::int64_t>(selection.by_rows ? row : column)});
  }
  sequence.has_drops = n > 1;
  sequence.unit = unit_of(table, selection.columns[0]);
  return sequence;
}

bool falls(const Sequence& sequence) {
  for (std::size_t k = 1; k < sequence.values.size(); ++k)
    if (sequence.values[k].number.value >= sequence.values[k - 1].number.value) return false;
  return true;
}

/// What a column without a unit would be: times of a ball; or where they do not rise intervals, or heights.
std::vector<Reading> likely_readings(const ForeignTable& table, std::size_t column) {
  const Selection selection{{column}, Dimension::time, false};
  const Sequence sequence = glance_at(table, selection);
  if (unit_of(table, column) || sequence.values.size() < 3 || has_equal_steps(sequence) || numbers_rows(table, column))
    return {};
  const bool times = rises(sequence);
  if (!times && goes_up_and_down(sequence)) return {};
  for (std::size_t k = 1; k < sequence.values.size(); ++k)
    if (times && sequence.values[k].number.value == sequence.values[k - 1].number.value) return {};
  std::vector<Reading> likely;
  for (const char* as : times ? std::vector{"times"} : std::vector{"intervals", "heights"}) {
    const bool heights = *as == 'h';
    if (heights && !falls(sequence)) continue;
    const std::vector<Reading> readings =
        readings_of(sequence, {as}, false, table.options,
                    heights ? column_option(table, "h", column) : with_drops(table, selection));
    if (readings.empty()) continue;
    likely.push_back(readings.front());
    likely.back().meaning += " by " + column_name(table, column);
  }
  return likely;
}

/// What the columns of a table may be, and what table.options leave of it.
struct Columns {
  std::vector<std::size_t> measured, times, lengths;  ///< with any unit, one of time, one of length
  bool is_told = false;                               ///< what the numbers are
  bool are_heights = false;
  std::vector<Reading> likely;  ///< of columns without a unit
  std::vector<std::size_t> likely_times;
  bool is_row = false;      ///< the only row holds one quantity
  Selection several;        ///< drops side by side, or one in each row; or the only row. No column where there is none
  bool are_proved = false;  ///< of rows: no title and no other column may say something else

  Columns(const ForeignTable& table) : is_told(table.options.as != "auto") {
    std::vector<std::size_t> all;
    for (std::size_t k = 0; k < table.n_columns(); ++k) {
      all.push_back(k);
      if (const auto unit = unit_of(table, k)) {
        measured.push_back(k);
        if (unit->dimension == Dimension::time) times.push_back(k);
        if (unit->dimension == Dimension::length) lengths.push_back(k);
      }
      for (Reading& reading : likely_readings(table, k)) {
        if (reading.options.as == "times") likely_times.push_back(k);
        likely.push_back(std::move(reading));
      }
    }
    are_heights =
        table.options.as == "heights" || (!is_told && (unit_called(table.options.unit).dimension == Dimension::length ||
                                                       (times.empty() && !lengths.empty())));
    const bool are_measured = !measured.empty();
    const Selection columns{are_measured ? wanted() : likely_times, dimension(), false};
    Selection rows{are_measured ? wanted() : bare_columns(table, true), dimension(), true};
    is_row = table.rows.size() == 1 && are_alike(table, rows.columns) &&
             std::all_of(all.begin(), all.end(), [&](std::size_t k) {
               return table.rows[0].cells[k].empty() || std::count(rows.columns.begin(), rows.columns.end(), k) > 0;
             });
    const bool are_columns = !is_row && are_alike(table, columns.columns) && goes_one_way(glance_at(table, columns));
    are_proved = is_row || are_measured || table.titles.empty();
    bool are_rows = is_row || (are_alike(table, rows.columns) && goes_one_way(glance_at(table, rows)));
    if (!are_rows && !are_measured && !are_columns) {  // beside their numbers
      rows.columns = bare_columns(table, false);
      are_rows = are_alike(table, rows.columns) && goes_one_way(glance_at(table, rows));
      are_proved = false;
    }
    if (are_columns || are_rows) several = are_columns ? columns : rows;
  }

  const std::vector<std::size_t>& wanted() const { return are_heights ? lengths : times; }
  Dimension dimension() const { return are_heights ? Dimension::length : Dimension::time; }

 private:
  static bool are_alike(const ForeignTable& table, const std::vector<std::size_t>& columns) {
    const auto name = [&](std::size_t k) { return unit_of(table, k).value_or(TitleUnit{}).name; };
    return columns.size() > 1 &&
           std::all_of(columns.begin(), columns.end(), [&](std::size_t k) { return name(k) == name(columns[0]); });
  }
};

/// Another column beside the one with a unit that may be meant, or that makes each row another measurement.
std::optional<std::size_t> rival_of(const ForeignTable& table, const Columns& columns) {
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    if (unit_of(table, k) || title_of(table, k) == "drop" || numbers_rows(table, k)) continue;
    const Sequence beside = glance_at(table, {{k}, columns.dimension(), false});
    const bool names_unit = title_of(table, k).find_first_of("([/^") != std::string::npos;
    const auto& times = columns.likely_times;
    if (columns.are_heights ? !columns.is_told && !beside.values.empty()
                            : (goes_one_way(beside) && !names_unit) || std::count(times.begin(), times.end(), k) > 0)
      return k;
  }
  return std::nullopt;
}

/// What the table proves to be read.
std::optional<Selection> proved(const ForeignTable& table, const Columns& columns) {
  for (const Dimension dimension : {Dimension::time, Dimension::length})
    if (Selection told{told_columns(table, dimension == Dimension::time ? "t" : "h"), dimension, false};
        !told.columns.empty()) {
      Selection rows = told;
      rows.by_rows = true;
      return !goes_one_way(glance_at(table, told)) && goes_one_way(glance_at(table, rows)) ? rows : told;
    }
  if (const auto own = own_column(table, "t_s"); own && !columns.are_heights)
    return Selection{{*own}, Dimension::time, false};
  if (columns.several.by_rows && columns.are_proved && (columns.is_told || (columns.is_row && table.titles.empty())))
    return columns.several;
  const std::vector<std::size_t>& wanted = columns.wanted();
  if (wanted.size() == 1 && (columns.measured.size() == 1 || columns.is_told) && !rival_of(table, columns))
    return Selection{wanted, columns.dimension(), false};
  const bool is_only = table.n_columns() == 1 && wanted.size() == columns.measured.size();
  if (is_only && (columns.is_told || table.titles.empty())) return Selection{{0}, columns.dimension(), false};
  return std::nullopt;
}

/// Asks where a time goes on by equal steps, or a position goes up and down, and nothing is told.
void check_for_path(const ForeignTable& table, const Columns& columns) {
  if (table.options.as != "auto" || !table.options.columns.empty() || table.rows.size() < kFrames) return;
  const bool are_bare = columns.measured.empty();
  for (std::size_t k = 0; k < table.n_columns(); ++k) {
    const Sequence sequence = glance_at(table, {{k}, Dimension::time, false});
    const auto& values = sequence.values;
    if (values.size() < kFrames) continue;
    const auto& unit = sequence.unit;
    constexpr double kLongestFrame_s = 0.2;
    const double step = values[1].number.value - values[0].number.value;
    if (has_equal_steps(sequence) &&
        (unit ? unit->dimension == Dimension::time : are_bare && !numbers_rows(table, k) && step <= kLongestFrame_s))
      ask_about_path(table, k, true,
                     unit ? std::vector<Reading>{{"if each is an impact",
                                                  {"times", table.options.unit, column_option(table, "t", k)}}}
                          : columns.likely);
    if (goes_up_and_down(sequence) &&
        (unit ? unit->dimension == Dimension::length : columns.likely.empty() && are_bare))
      ask_about_path(table, k, false, {});
  }
}

/// Heights before and after a bounce, of two columns without a unit.
std::vector<Reading> bare_heights(const ForeignTable& table) {
  std::vector<std::size_t> bare = bare_columns(table, true);
  if (bare.size() > 2) bare = bare_columns(table, false);
  const std::vector<std::size_t> pair = before_and_after(table, bare);
  if (pair.empty()) return {};
  std::vector<Reading> readings =
      readings_of(glance_at(table, {{pair[0]}, Dimension::length, false}), {"heights"}, false, table.options,
                  column_option(table, "h0", pair[0]) + "," + column_option(table, "h", pair[1]));
  for (Reading& reading : readings) reading.options.as = "auto", reading.meaning += ", before and after a bounce";
  return readings;
}

}  // namespace

void ask_about_path(const ForeignTable& table, std::size_t column, bool has_steps, std::vector<Reading> readings) {
  ask(table,
      column_name(table, column) +
          (has_steps ? " is equally spaced, as the frames of a video are"
                     : " goes up and down, as the path of a video does") +
          "; impact times are needed: leave the rows of the impacts only (--as times), or write the heights of the "
          "highest points (--as heights)",
      std::move(readings));
}

Selection selection_of(const ForeignTable& table) {
  const Columns columns(table);
  if (auto selection = proved(table, columns)) return *std::move(selection);
  check_for_path(table, columns);
  const std::vector<std::size_t>&times = columns.times, &lengths = columns.lengths;
  std::vector<Reading> readings;
  const auto one = [&](std::size_t k, bool heights) {
    const Selection selection{{k}, heights ? Dimension::length : Dimension::time, false};
    readings.push_back({(heights ? "heights, one after the other, of " : "") + column_name(table, k),
                        {heights ? "heights" : table.options.as, table.options.unit, with_drops(table, selection)}});
  };
  const auto pair = [&](std::size_t before, std::size_t after, const char* as) {
    readings.push_back(
        {"before and after a bounce, from " + column_name(table, before) + " to " + column_name(table, after),
         {as, table.options.unit, column_option(table, "h0", before) + "," + column_option(table, "h", after)}});
  };
  std::string question;
  if (columns.is_row && !columns.measured.empty()) {
    question = columns.are_heights ? "has heights in a row: of one ball, from its release on?"
                                   : std::to_string(times.size()) + " columns are of a time, in one row: of one ball?";
  } else if (const auto rival = rival_of(table, columns);
             rival && columns.wanted().size() == 1 && columns.measured.size() == 1) {
    one(columns.wanted()[0], columns.are_heights);
    question = columns.are_heights ? "has heights and another column of numbers: what is it?"
                                   : column_name(table, *rival) +
                                         " rises or falls beside the times: are the rows the bounces of one ball, one "
                                         "after the other, and which column is read?";
    if (columns.are_heights)
      pair(lengths[0], *rival, "heights");
    else
      readings.insert(readings.end(), columns.likely.begin(), columns.likely.end());
  } else if (table.options.as == "heights" || lengths.size() > 2) {
    question = "which column holds heights?";
    for (std::size_t k = 0; k < table.n_columns(); ++k)
      if (table.number(table.rows.front(), k) && !numbers_rows(table, k)) one(k, true);
    if (readings.size() == 2 && table.n_columns() == 2) pair(0, 1, "heights");
  } else if (columns.are_heights && lengths.size() == 2 && columns.measured.size() == 2) {
    question = "two columns are heights: before and after a bounce?";
    const auto x = table.number(table.rows.front(), lengths[0]), y = table.number(table.rows.front(), lengths[1]);
    const bool falls = !x || !y || std::abs(x->value) >= std::abs(y->value);
    pair(lengths[falls ? 0 : 1], lengths[falls ? 1 : 0], "auto");
  } else if (!times.empty()) {
    question = times.size() > 1 ? std::to_string(times.size()) + " columns are of a time; which is read?"
                                : "has a time and another measured quantity: which is to be read?";
    for (const std::size_t k : times) one(k, false);
    for (const std::size_t k : lengths)
      if (times.size() == 1) one(k, true);
  } else if (!columns.measured.empty()) {
    question = "no column is a time: " + column_name(table, columns.measured.front()) +
               " is another quantity (bouncelab fit takes speeds and coefficients)";
  } else {
    question = table.titles.empty() ? "which column is of times or intervals?"
                                    : "no title has a unit, such as Time (s), h (cm) or v (m/s); numbers of frames or "
                                      "samples are to be divided by their rate first";
    for (std::size_t k = 0; k < table.n_columns(); ++k)
      if (has_unit(table.rows.front().cells[k])) number_in(table, table.rows.front(), k);
    readings = columns.likely;
    if (!columns.several.by_rows)
      for (const std::vector<Reading>& more : {bare_heights(table), speed_readings(table)})
        readings.insert(readings.begin(), more.begin(), more.end());
  }
  const Selection& several = columns.several;
  if (several.columns.empty() || !table.options.columns.empty() || (columns.are_heights && !several.by_rows))
    ask(table, question, std::move(readings));
  const Sequence numbers = glance_at(table, several);
  const bool are_measured = !columns.measured.empty(), are_times = !columns.are_heights && rises(numbers);
  std::vector<const char*> as;
  if (!columns.are_heights) as.push_back(are_times ? "times" : "intervals");
  if (columns.are_heights || (!are_times && !are_measured)) as.push_back("heights");
  for (const char* kind : as)
    for (const Reading& reading : readings_of(numbers, {kind}, are_measured, table.options,
                                              several.by_rows && columns.are_proved
                                                  ? ""
                                                  : columns_option(table, *kind == 'h' ? "h" : "t", several.columns)))
      readings.push_back(
          {(several.by_rows ? "a drop in each row, " : "a drop in each column, ") + reading.meaning, reading.options});
  ask(table, question, std::move(readings));
}

}  // namespace bouncelab
