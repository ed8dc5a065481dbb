// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of one to four drops in every shape that docs/formats.md, "Files of other programs", reads give their times
// back within the digits written; in shapes that it does not read they never give numbers.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

enum class Told { by_column, by_blank_lines, by_order, by_pauses };
enum class Cells { numbers, clock, dates, since_1970 };

class Shape {
 public:
  explicit Shape(unsigned seed) : random_(seed) {}
  bool may(double probability = 0.5) { return std::uniform_real_distribution<>()(random_) < probability; }
  double within(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  template <class List>
  auto one_of(const List& list) {
    return *(std::begin(list) + std::uniform_int_distribution<std::ptrdiff_t>(0, std::ssize(list) - 1)(random_));
  }

 private:
  std::mt19937 random_;
};

struct Unit {
  const char* name;
  double si;
  int decimals;  ///< 1 ms or better, of every kind
};
constexpr std::array<Unit, 6> kNumberUnits{{{"s", 1.0, 4},
                                            {"ms", 1e-3, 1},
                                            {"us", 1e-6, 0},
                                            {"\xC2\xB5s", 1e-6, 1},
                                            {"\xCE\xBCs", 1e-6, 0},
                                            {"min", 60.0, 7}}};
constexpr std::array<Unit, 4> kSince1970{{{"s", 1.0, 4}, {"ms", 1e-3, 1}, {"us", 1e-6, 0}, {"ns", 1e-9, 0}}};
constexpr double kDay_s = 1795824000.0;  // 2026-11-28

std::string date_of(double t_s, int decimals, double zone_h, const char* zone, char between) {
  const double local_s = t_s - kDay_s + 3600.0 * zone_h, whole_s = std::floor(local_s);
  const int second = static_cast<int>(whole_s);
  const std::string fraction = formatted("%.*f", decimals, local_s - whole_s).substr(1);
  return formatted("2026-11-28%c%02d:%02d:%02d", between, second / 3600, second / 60 % 60, second % 60) + fraction +
         zone;
}

struct Written {
  std::string text;
  std::vector<std::vector<double>> drops_s;
  double rounding_s = 0.0;
  bool intervals = false;
};

/// What a shape does that the rule does not read.
enum class Flaw { none, two_times, no_unit, falling, mean, frames, height, reference, signs };

Written written(Shape& shape, Flaw flaw) {
  Written result;
  const bool is_plain = flaw != Flaw::none && flaw != Flaw::two_times && flaw != Flaw::height;
  result.intervals = flaw == Flaw::falling || (flaw == Flaw::none && shape.may(0.3));
  const Cells cells = result.intervals || is_plain || shape.may()
                          ? Cells::numbers
                          : shape.one_of(std::array{Cells::clock, Cells::dates, Cells::since_1970});
  const Told told =
      flaw == Flaw::frames || flaw == Flaw::falling
          ? Told::by_pauses
          : shape.one_of(std::array{Told::by_column, Told::by_blank_lines, Told::by_order, Told::by_pauses});
  const int n_drops = flaw == Flaw::frames ? 1 : shape.one_of(std::array{1, 2, 3, 4});
  const bool has_index = flaw == Flaw::mean || shape.may(0.3), has_level = shape.may(0.3);
  const bool has_column = told == Told::by_column, may_have_note = shape.may(0.3);
  const bool has_others =
      has_column || has_index || has_level || may_have_note || flaw == Flaw::two_times || flaw == Flaw::height;
  // without titles a column alone, of numbers in seconds or of cells that say what they are
  const bool has_titles = has_others || flaw == Flaw::no_unit || flaw == Flaw::reference || flaw == Flaw::signs ||
                          (result.intervals && flaw == Flaw::none) || shape.may(0.8);
  const char separator = has_titles && !(cells == Cells::dates) ? shape.one_of(std::array{'\t', ';', ',', ' '}) : ';';
  const bool quoted = shape.may(0.3);
  // alone and without titles a decimal comma may separate
  const char decimal = has_titles && (separator != ',' || quoted) && shape.may() ? ',' : '.';
  Unit unit = shape.one_of(kNumberUnits);
  if (!has_titles || flaw == Flaw::signs || flaw == Flaw::no_unit) unit = kNumberUnits[0];
  if (cells == Cells::since_1970) unit = shape.one_of(kSince1970);
  if (cells == Cells::clock || cells == Cells::dates) unit = {"", 1.0, shape.one_of(std::array{3, 4, 5})};
  result.rounding_s = 0.5 * unit.si * std::pow(10.0, -unit.decimals);
  const double base_s = cells == Cells::clock     ? shape.one_of(std::array{1.0, 58.0, 3598.0})
                        : cells == Cells::numbers ? 0.0
                                                  : kDay_s + 36000.0;

  std::vector<std::vector<double>> values_s;  // as they are written
  double begin_s = shape.within(0.0, 0.5);
  for (int drop = 0; drop < n_drops; ++drop) {
    const int n = shape.one_of(std::array{5, 6, 8});
    const double eps = shape.within(0.7, 0.8);
    double flight_s = shape.within(0.5, 0.6), t_s = begin_s;
    if (flaw == Flaw::frames) t_s = 0.0;
    values_s.emplace_back();
    result.drops_s.emplace_back();
    if (result.intervals) result.drops_s.back().push_back(0.0);
    for (int k = 0; k < (flaw == Flaw::frames ? 12 : n); ++k) {
      if (!result.intervals) result.drops_s.back().push_back(base_s + t_s);
      t_s += flaw == Flaw::frames ? 0.1 : flight_s;
      if (result.intervals) result.drops_s.back().push_back(t_s - begin_s);
      values_s.back().push_back(result.intervals ? flight_s : result.drops_s.back().back());
      flight_s *= eps;
    }
    begin_s = told == Told::by_order || (told != Told::by_pauses && shape.may()) ? shape.within(0.0, 0.4)
                                                                                 : t_s + shape.within(3.0, 5.0);
  }

  const bool blanks = separator == ' ', has_note = may_have_note && !blanks;  // between blanks all are numbers
  const std::string between(1, separator);
  const auto number_text = [&](double value, int decimals) {
    std::string text =
        shape.may(0.1) && decimals < 7 && value < 1e6 ? formatted("%.9fE0", value) : formatted("%.*f", decimals, value);
    std::replace(text.begin(), text.end(), '.', decimal);
    return text;
  };
  const char* zone = shape.one_of(std::array{"", "Z", "+01:00", "-0530"});
  const double zone_h = *zone == '+' ? 1.0 : *zone == '-' ? -5.5 : 0.0;
  const char before_time = shape.one_of(std::array{'T', ' '});
  const bool hours = shape.may();
  const auto time_text = [&](double t_s) {
    const double grid = std::pow(10.0, unit.decimals);  // no second that rounds to the next
    if (cells == Cells::clock || cells == Cells::dates)
      t_s = std::round(t_s * grid) / grid + (cells == Cells::clock ? 1e-9 : 5e-7);
    if (cells == Cells::dates) return date_of(t_s, unit.decimals, zone_h, zone, before_time);
    if (cells != Cells::clock) return number_text(t_s / unit.si, unit.decimals);
    const int minutes = static_cast<int>(t_s / 60.0);
    std::string seconds = formatted("%0*.*f", unit.decimals + 3, unit.decimals, t_s - 60.0 * minutes);
    std::replace(seconds.begin(), seconds.end(), '.', decimal);
    return hours ? formatted("%02d:%02d:", minutes / 60, minutes % 60) + seconds : formatted("%d:", minutes) + seconds;
  };
  const auto in_quotes = [&](const std::string& cell) { return quoted ? "\"" + cell + "\"" : cell; };
  const std::string end = shape.may() ? "\r\n" : "\n";
  const std::string rest = blanks || !has_titles ? "" : std::string(shape.one_of(std::array{0U, 0U, 2U}), separator);

  std::string text = shape.may(0.2) ? "\xEF\xBB\xBF" : "";
  if (has_titles && shape.may(0.3)) text += "Recorded by Anna" + end + end + "ball" + between + "steel" + end;
  if (shape.may(0.3)) text += "# 3 mm, 5 drops" + end;
  std::vector<std::string> titles;
  if (has_column) titles.emplace_back("drop");
  if (has_index) titles.emplace_back("No.");
  const std::string quantity = result.intervals ? shape.one_of(std::array{"dt", "\xCE\x94t", "interval"})
                                                : shape.one_of(std::array{"Time", "t", "Zeit", "run"});
  const bool is_known = quantity != "Zeit" && quantity != "run";  // for a unit behind / or _
  const std::string name = unit.name;
  std::array<std::string, 4> spellings{quantity + (blanks ? "(" : " (") + name + ")", quantity + "[" + name + "]",
                                       (is_known ? quantity : "t") + (blanks ? "/" : " / ") + name,
                                       (is_known ? quantity : "t") + "_" + name};
  if (name == "min") spellings[3] = spellings[0];  // t_min is no minutes
  titles.push_back(cells == Cells::numbers ? shape.one_of(spellings) : "Start");
  if (flaw == Flaw::no_unit || flaw == Flaw::falling) titles.back() = "Time";
  if (flaw != Flaw::none && titles.back() == "t_s") titles.back() = "Time_s";  // t_s is read whatever stands beside it
  if (flaw == Flaw::two_times) titles.emplace_back(shape.one_of(std::array{"End(s)", "t[ms]", "tau_us"}));
  if (flaw == Flaw::height) titles.emplace_back(shape.one_of(std::array{"y(m)", "h[cm]", "v/m/s"}));
  if (has_level) titles.emplace_back(blanks ? "level" : "level (dB)");
  if (has_note) titles.emplace_back("note");
  if (has_titles) {
    for (std::size_t k = 0; k < titles.size(); ++k) text += (k == 0 ? "" : between) + in_quotes(titles[k]);
    text += rest + end;
  }
  const auto n_rows = [&] {
    std::size_t n = 0;
    for (const auto& drop : values_s) n += drop.size();
    return n;
  }();
  const auto flawed = static_cast<std::size_t>(shape.within(1.0, static_cast<double>(n_rows) - 0.01));
  std::size_t row = 0;
  for (std::size_t drop = 0; drop < values_s.size(); ++drop) {
    if (drop > 0 && told == Told::by_blank_lines)
      text += (shape.may() && !blanks ? std::string(2, separator) : "") + end;
    for (std::size_t k = 0; k < values_s[drop].size(); ++k, ++row) {
      std::vector<std::string> line;
      if (has_column)
        line.push_back(k > 0 && !blanks && shape.may(0.2)
                           ? ""
                           : (blanks || flaw == Flaw::mean ? "" : "trial ") + std::to_string(drop + 3));
      if (has_index) line.push_back(std::to_string(row + 1));
      std::string time = time_text(values_s[drop][k]);
      if (flaw == Flaw::reference && row == flawed) time = "#REF!";
      if (flaw == Flaw::signs && row == flawed) {
        time = formatted("%.4f", values_s[drop][k]);
        if (decimal == '.') std::replace(time.begin(), time.end(), '.', ',');
      }
      line.push_back(time);
      if (flaw == Flaw::two_times || flaw == Flaw::height)
        line.push_back(number_text(0.1 + values_s[drop][k] - base_s, 3));
      if (has_level) line.push_back(number_text(shape.within(-40.0, -5.0), 1));
      if (has_note) line.emplace_back("heard at " + std::to_string(row));
      for (std::size_t c = 0; c < line.size(); ++c) text += (c == 0 ? "" : between) + in_quotes(line[c]);
      text += rest + end;
    }
  }
  if (flaw == Flaw::mean) {
    text += "Mean";
    for (std::size_t c = 1; c < titles.size(); ++c) text += between + in_quotes(number_text(0.5, 3));
    text += end;
  }
  result.text = text;
  return result;
}

Onsets onsets_in(const std::string& text, std::string& taken_for) {
  const TakenTable taken = onsets_from_foreign(read_foreign_table(decoded_text(text, "x"), "x"));
  taken_for = taken.taken_for;
  return onsets_from_table(taken.table, "x");
}

TEST(ForeignTables, OfEveryShapeGiveTheirTimesBack) {
  for (unsigned seed = 1; seed <= 400; ++seed) {
    Shape shape(seed);
    const Written table = written(shape, Flaw::none);
    SCOPED_TRACE(table.text);
    Onsets onsets;
    std::string taken_for;
    try {
      onsets = onsets_in(table.text, taken_for);
    } catch (const Error& error) {
      ADD_FAILURE() << seed << ": " << error.what();
      continue;
    }
    std::size_t n = 0;
    for (std::size_t drop = 0; drop < table.drops_s.size(); ++drop)
      for (std::size_t k = 0; k < table.drops_s[drop].size(); ++k, ++n) {
        ASSERT_LT(n, onsets.size()) << seed << ": " << taken_for;
        ASSERT_EQ(onsets[n].drop, static_cast<std::int64_t>(drop)) << seed << ", impact " << k << ": " << taken_for;
        // intervals add up; times since 1970 stand on a grid of 2.4e-7 s
        const double tolerance_s = table.rounding_s * (table.intervals ? static_cast<double>(k) : 1.0) + 5e-7;
        ASSERT_NEAR(onsets[n].t_s, table.drops_s[drop][k], tolerance_s) << seed << ": " << taken_for;
      }
    EXPECT_EQ(onsets.size(), n) << seed << ": " << taken_for;
  }
}

TEST(ForeignTables, OfOtherShapesNeverGiveNumbers) {
  for (const Flaw flaw : {Flaw::two_times, Flaw::no_unit, Flaw::falling, Flaw::mean, Flaw::frames, Flaw::height,
                          Flaw::reference, Flaw::signs})
    for (unsigned seed = 1; seed <= 50; ++seed) {
      Shape shape(seed);
      const Written table = written(shape, flaw);
      SCOPED_TRACE(table.text);
      std::string taken_for;
      EXPECT_THROW(onsets_in(table.text, taken_for), Error)
          << static_cast<int>(flaw) << "." << seed << ": " << taken_for;
    }
}

}  // namespace
}  // namespace bouncelab
