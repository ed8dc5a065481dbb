// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <istream>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::size_t kMostTitleLines = 200;  // of an oscilloscope's settings
constexpr std::size_t kRowsToDecide = 16;     // sound does not grow by equal steps for so long
constexpr std::size_t kTextSamplesAtOnce = 1 << 16;
constexpr std::size_t kMostColumns = 1024;

constexpr double kTolerance_steps = 0.25;  // half a step would be another sample
constexpr std::int64_t kEvery = 1024;      // of the times are kept, to see a drift

struct Row {
  std::size_t line = 0;
  std::vector<NumberCell> cells;
};

/// The rows of numbers of a table, and the titles in front of them.
class NumberRows {
 public:
  NumberRows(std::istream& in, const std::string& name) : lines_(in, name) {}

  /// @return false after the last. @throws FileError
  bool next(Row& row) {
    for (std::string line; lines_.next(line);) {
      const bool is_empty = line.find_first_not_of(" \t\r,;") == std::string::npos;
      if (is_empty || line.front() == '#') continue;
      if (!is_begun_ && !begin(line)) continue;
      take(line, row);
      return true;
    }
    if (!is_begun_) throw FileError(lines_.name(), "holds no numbers; a table of samples or a recording is needed");
    return false;
  }

  /// What stands above a column, of all lines of titles.
  std::string title(std::size_t column) const {
    std::string all;
    for (const std::string& line : titles_) {
      const std::vector<std::string_view> cells = cells_of(line, format_.separator);
      if (columns_[column] < cells.size()) all += std::string(cells[columns_[column]]) + " ";
    }
    return all;
  }
  std::size_t n_columns() const { return columns_.size(); }

 private:
  /// Whether the numbers begin with this line.
  bool begin(const std::string& line) {
    const std::optional<CellFormat> format = format_of(line);
    if (!format) {
      if (titles_.size() == kMostTitleLines)
        throw FileError(lines_.name(), "line " + std::to_string(lines_.number()) +
                                           ": no numbers up to here; a table of samples or a recording is needed");
      titles_.push_back(line);
      return false;
    }
    format_ = *format;
    const bool has_titles =
        std::any_of(titles_.begin(), titles_.end(), [](const std::string& t) { return t.find(',') != t.npos; });
    if (is_ambiguous(line, format_) && !has_titles)
      throw FileError(lines_.name(), "line " + std::to_string(lines_.number()) + ": " + printable(line) +
                                         " is one number or two; write a decimal point, or separate by ;");
    const std::vector<std::string_view> cells = cells_of(line, format_.separator);
    n_cells_ = cells.size();
    for (std::size_t k = 0; k < cells.size(); ++k)
      if (!cells[k].empty()) columns_.push_back(k);
    if (columns_.size() > kMostColumns)
      throw FileError(lines_.name(), "has " + std::to_string(columns_.size()) + " columns; write one row for a sample");
    return is_begun_ = true;
  }

  void take(const std::string& line, Row& row) const {
    const std::vector<std::string_view> cells = cells_of(line, format_.separator);
    const auto place = [&] { return "line " + std::to_string(lines_.number()); };
    if (cells.size() != n_cells_)
      throw FileError(lines_.name(), place() + " has " + std::to_string(cells.size()) + " cells, the first row has " +
                                         std::to_string(n_cells_));
    row.line = lines_.number();
    row.cells.clear();
    for (const std::size_t column : columns_) {
      const std::optional<NumberCell> number = number_of(cells[column], format_.decimal);
      if (!number)
        throw FileError(lines_.name(), place() + ", column " + std::to_string(column + 1) + ": '" +
                                           printable(cells[column]) + "' is not a number; correct or remove the row");
      row.cells.push_back(*number);
    }
  }

  LineReader lines_;
  bool is_begun_ = false;
  std::vector<std::string> titles_;
  CellFormat format_;
  std::size_t n_cells_ = 0;
  std::vector<std::size_t> columns_;  // that hold numbers
};

enum class FirstColumn { sample, index, time };

/// What the first column is, by its title and its first rows.
FirstColumn first_column_of(const NumberRows& table, const std::vector<Row>& rows) {
  if (table.n_columns() < 2) return FirstColumn::sample;
  if (is_time_title(table.title(0))) return FirstColumn::time;
  if (rows.size() < 3) return FirstColumn::sample;
  const double step = rows[1].cells[0].value - rows[0].cells[0].value;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const NumberCell &before = rows[k - 1].cells[0], &here = rows[k].cells[0];
    const double rounding = 2.0 * (before.rounding + here.rounding);
    if (!(here.value > before.value) || std::abs(here.value - before.value - step) > 0.1 * step + rounding)
      return FirstColumn::sample;
  }
  return step == 1.0 ? FirstColumn::index : FirstColumn::time;
}

/// The times of samples as a table gives them, which must be uniform: t_k = t_0 + k/rate to a quarter of a step, or as
/// well as they were rounded.
class TimeGrid {
 public:
  /// @param name  of the file, for messages
  explicit TimeGrid(std::string name) : name_(std::move(name)) {}
  /// The next time. @param rounding_s  half a unit of its last digit. @param line  of the file
  /// @throws FileError naming line and times: it does not grow, samples are missing, or the step changes
  void add(double t_s, double rounding_s, std::size_t line);
  /// @return the sampling rate [Hz]; a whole number where the rounding of the times allows one
  /// @throws FileError where there are fewer than two times, or they drift against any one rate
  double rate_hz() const;

 private:
  struct Entry {
    std::int64_t k = 0;
    double t_s = 0.0;
    std::size_t line = 0;
  };
  [[noreturn]] void refuse(std::size_t line, double t_s, double expected_s, double step_s) const;

  std::string name_;
  std::int64_t n_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, rounding_s_ = 0.0;
  std::vector<Entry> some_;  // one of kEvery
};

void TimeGrid::refuse(std::size_t line, double t_s, double expected_s, double step_s) const {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), "time %.9g s, where steps of %.6g s lead to %.9g s", t_s, step_s, expected_s);
  throw FileError(name_,
                  "line " + std::to_string(line) + ": " + text.data() +
                      "; samples must follow at one rate: record again, or leave the column out and give --rate");
}

void TimeGrid::add(double t_s, double rounding_s, std::size_t line) {
  rounding_s_ = std::max(rounding_s_, rounding_s);
  if (n_ == 0) first_s_ = t_s;
  if (n_ > 0 && !(t_s > first_s_)) refuse(line, t_s, last_s_, 0.0);
  if (n_ > 1) {
    // the line through the first time and the one before: their roundings and its own
    const double k = static_cast<double>(n_ - 1);
    const double step_s = (last_s_ - first_s_) / k;
    const double expected_s = last_s_ + step_s;
    if (std::abs(t_s - expected_s) > kTolerance_steps * step_s + 2.0 * rounding_s_ * (1.0 + 1.0 / k))
      refuse(line, t_s, expected_s, step_s);
  }
  if (n_ % kEvery == 0) some_.push_back({n_, t_s, line});
  last_s_ = t_s;
  ++n_;
}

double TimeGrid::rate_hz() const {
  if (n_ < 2) throw FileError(name_, "holds " + std::to_string(n_) + " samples; record again");
  const double step_s = (last_s_ - first_s_) / static_cast<double>(n_ - 1);
  for (const Entry& entry : some_) {
    const double expected_s = first_s_ + static_cast<double>(entry.k) * step_s;
    if (std::abs(entry.t_s - expected_s) > 2.0 * kTolerance_steps * step_s + 2.0 * rounding_s_)
      refuse(entry.line, entry.t_s, expected_s, step_s);
  }
  const double rate_hz = 1.0 / step_s;
  const double error_hz = 2.0 * rounding_s_ / (last_s_ - first_s_) * rate_hz;
  return std::abs(rate_hz - std::round(rate_hz)) <= std::max(error_hz, 1e-9 * rate_hz) ? std::round(rate_hz) : rate_hz;
}

}  // namespace

bool is_text(SoundBytes& bytes) {
  std::array<std::byte, 4096> head{};
  const std::int64_t n = bytes.read(0, head);
  const auto begins = [&](unsigned a, unsigned b) {
    return n >= 4 && std::to_integer<unsigned>(head[0]) == a && std::to_integer<unsigned>(head[1]) == b;
  };
  // UTF-16 with its mark and a character of Latin; sound of MPEG layer I begins with FF FE too
  if ((begins(0xFF, 0xFE) && head[3] == std::byte{0}) || (begins(0xFE, 0xFF) && head[2] == std::byte{0})) return true;
  return n > 0 && std::all_of(head.begin(), head.begin() + n, [](std::byte b) {
           const auto c = std::to_integer<unsigned char>(b);
           return c == '\t' || c == '\n' || c == '\r' || (c >= ' ' && c != 0x7F);
         });
}

SoundInfo read_number_text(std::istream& in, const std::string& name, std::optional<double> rate_hz,
                           DecodedSamples& samples) {
  NumberRows table(in, name);
  std::vector<Row> first_rows;
  Row row;
  while (first_rows.size() < kRowsToDecide && table.next(row)) first_rows.push_back(row);
  const FirstColumn first_column = first_column_of(table, first_rows);
  const bool has_times = first_column == FirstColumn::time;
  if (has_times && rate_hz)
    throw InvalidArgument("--rate: " + name + " has a column of times, which give its rate; leave --rate out");
  if (!has_times && !rate_hz)
    throw FileError(name, "holds numbers without times; give their sampling rate: --rate 48000");

  const std::size_t n_skipped = first_column == FirstColumn::sample ? 0 : 1;
  const double unit_s = has_times ? time_unit_s(table.title(0)).value_or(1.0) : 1.0;
  SoundInfo info;
  TimeGrid times(name);
  std::vector<float> waiting;
  const auto take = [&](const Row& r) {
    if (has_times) times.add(unit_s * r.cells[0].value, unit_s * r.cells[0].rounding, r.line);
    for (std::size_t k = n_skipped; k < r.cells.size(); ++k) waiting.push_back(static_cast<float>(r.cells[k].value));
    ++info.n_frames;
    if (waiting.size() < kTextSamplesAtOnce) return;
    samples.append(waiting);
    waiting.clear();
  };
  for (const Row& r : first_rows) take(r);
  while (table.next(row)) take(row);
  samples.append(waiting);
  info.rate_hz = has_times ? times.rate_hz() : *rate_hz;
  check_rate(info.rate_hz, name);
  info.n_channels = static_cast<int>(table.n_columns() - n_skipped);
  info.description = "table of text, " + std::to_string(table.n_columns()) + " columns";
  return info;
}

}  // namespace bouncelab::audio
