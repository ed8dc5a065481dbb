// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/coded_sound.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <istream>
#include <string_view>
#include <utility>
#include <vector>

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
    const std::vector<CellFormat> formats = formats_of(line);
    if (formats.empty()) {
      if (titles_.size() == kMostTitleLines)
        throw FileError(lines_.name(), "line " + std::to_string(lines_.number()) +
                                           ": no numbers up to here; a table of samples or a recording is needed");
      titles_.push_back(line);
      return false;
    }
    const bool has_commas =
        std::any_of(titles_.begin(), titles_.end(), [](const std::string& t) { return t.find(',') != t.npos; });
    if (formats.size() > 1 && !has_commas)
      throw FileError(lines_.name(), "line " + std::to_string(lines_.number()) + ": " + printable(line) +
                                         " is one number or two; write a decimal point, or separate by ;");
    format_ = formats.front();
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
  const auto unit = unit_of_title(table.title(0));
  if (unit && unit->dimension == Dimension::time) return FirstColumn::time;
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

double unit_of_times(const NumberRows& table) {
  const auto unit = unit_of_title(table.title(0));
  return unit && unit->dimension == Dimension::time ? unit->si : 1.0;
}

/// The times of samples as a table gives them, which must be uniform: t_k = t_0 + k/rate to a quarter of a step, or as
/// well as they were rounded.
class TimeGrid {
 public:
  /// @param name  of the file, for messages
  explicit TimeGrid(std::string name) : name_(std::move(name)) {}
  /// The next time. @param rounding_s  half a unit of its last digit. @param line  of the file
  /// @throws FileError naming line and times: it does not grow, samples are missing, or the step changes
  void add(double t_s, double rounding_s, std::size_t line) {
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
  /// @return the sampling rate [Hz]; a whole number where the rounding of the times allows one
  /// @throws FileError where there are fewer than two times, or they drift against any one rate
  double rate_hz() const {
    if (n_ < 2) throw FileError(name_, "holds " + std::to_string(n_) + " samples; record again");
    const double step_s = (last_s_ - first_s_) / static_cast<double>(n_ - 1);
    for (const Entry& entry : some_) {
      const double expected_s = first_s_ + static_cast<double>(entry.k) * step_s;
      if (std::abs(entry.t_s - expected_s) > 2.0 * kTolerance_steps * step_s + 2.0 * rounding_s_)
        refuse(entry.line, entry.t_s, expected_s, step_s);
    }
    const double rate_hz = 1.0 / step_s;
    const double error_hz = 2.0 * rounding_s_ / (last_s_ - first_s_) * rate_hz;
    return std::abs(rate_hz - std::round(rate_hz)) <= std::max(error_hz, 1e-9 * rate_hz) ? std::round(rate_hz)
                                                                                         : rate_hz;
  }

 private:
  struct Entry {
    std::int64_t k = 0;
    double t_s = 0.0;
    std::size_t line = 0;
  };

  [[noreturn]] void refuse(std::size_t line, double t_s, double expected_s, double step_s) const {
    throw FileError(
        name_, "line " + std::to_string(line) + ": " +
                   formatted("time %.9g s, where steps of %.6g s lead to %.9g s", t_s, step_s, expected_s) +
                   "; samples must follow at one rate: record again (--rate states the rate of samples without times)");
  }

  std::string name_;
  std::int64_t n_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, rounding_s_ = 0.0;
  std::vector<Entry> some_;  // one of kEvery
};

}  // namespace

bool is_text(FileBytes& bytes) {
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

std::optional<double> step_of_number_text(std::istream& in) {
  constexpr std::size_t kLeastRows = 8;
  NumberRows table(in, "");
  std::vector<Row> rows;
  Row row;
  while (rows.size() < kRowsToDecide && table.next(row)) rows.push_back(row);
  if (rows.size() < kLeastRows || first_column_of(table, rows) != FirstColumn::time) return std::nullopt;
  return unit_of_times(table) * (rows[1].cells[0].value - rows[0].cells[0].value);
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
    throw FileError(name, "holds numbers without times or a sampling rate (--rate 48000 gives it)");

  const std::size_t n_skipped = first_column == FirstColumn::sample ? 0 : 1;
  const double unit_s = unit_of_times(table);
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

namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kLongestNpyHead_bytes = 1 << 16;
constexpr std::int64_t kMostNpyChannels = 1024;

struct NumberType {
  std::string_view name;
  int coding = 0;  ///< as libsndfile numbers it
  std::int64_t n_bytes = 0;
};

/// What stands behind 'KEY': in the head, a Python dictionary that NumPy writes in one way.
std::string_view value_behind(std::string_view head, std::string_view key) {
  const std::size_t at = head.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view value = head.substr(at + key.size());
  value.remove_prefix(std::min(value.find_first_not_of(": "), value.size()));
  return value;
}

/// (1000,) or (1000, 2).
std::vector<std::int64_t> shape_in(std::string_view text) {
  std::vector<std::int64_t> shape;
  if (text.empty() || text.front() != '(') return shape;
  const char *at = text.data() + 1, *end = text.data() + text.size();
  while (at < end) {
    std::int64_t n = 0;
    const auto [rest, error] = std::from_chars(at, end, n);
    if (error != std::errc() || n < 0) break;
    shape.push_back(n);
    at = std::find_if(rest, end, [](char c) { return c != ',' && c != ' '; });
  }
  return shape;
}

}  // namespace

bool is_npy(FileBytes& bytes) { return bytes.text(0, kMagic.size()) == kMagic; }

PlainSound npy_sound(FileBytes& bytes, std::optional<double> rate_hz) {
  const std::string& name = bytes.name();
  const auto refuse = [&](const std::string& what) { throw FileError(name, what); };
  const std::string start = bytes.text(0, 12);
  const auto byte = [&](std::size_t k) { return static_cast<std::size_t>(static_cast<unsigned char>(start[k])); };
  if (start.size() < 12) refuse("is a .npy file that was cut off in its head; save it again");
  const bool is_first = start[6] == 1;
  const std::size_t n_head = byte(8) | byte(9) << 8 | (is_first ? 0 : byte(10) << 16 | byte(11) << 24);
  const std::int64_t head_at = is_first ? 10 : 12;
  const std::string head = bytes.text(head_at, std::min(n_head, kLongestNpyHead_bytes));
  if (head.size() < n_head) refuse("is a .npy file that was cut off in its head; save it again");

  PlainSound sound;
  SoundInfo& info = sound.info;
  const std::string type(value_behind(head, "'descr'").substr(0, 5));
  constexpr std::array<NumberType, 3> kTypes{
      {{"'<i2'", SF_FORMAT_PCM_16, 2}, {"'<f4'", SF_FORMAT_FLOAT, 4}, {"'<f8'", SF_FORMAT_DOUBLE, 8}}};
  const auto number = std::find_if(kTypes.begin(), kTypes.end(), [&](const NumberType& t) { return t.name == type; });
  if (number == kTypes.end())
    refuse("holds numbers of the type " + type + "; save them as int16, float32 or float64: x.astype('<f4')");
  const std::vector<std::int64_t> shape = shape_in(value_behind(head, "'shape'"));
  const bool is_c_order = value_behind(head, "'fortran_order'").substr(0, 5) == "False";
  if (shape.empty() || shape.size() > 2) refuse("must have one dimension, or two: samples x channels");
  const std::int64_t n_channels = shape.size() == 2 ? shape[1] : 1;
  if (shape[0] == 0 || n_channels == 0) refuse("holds no samples; record again");
  if (shape.size() == 2 && n_channels > 1 && (!is_c_order || n_channels > std::min(shape[0], kMostNpyChannels)))
    refuse("must be samples x channels in C order; save it so: np.ascontiguousarray(x.T)");
  if (!rate_hz) refuse("a .npy file holds no sampling rate (--rate 48000 gives it)");
  info.rate_hz = *rate_hz;
  info.n_channels = static_cast<int>(n_channels);
  info.n_frames = shape[0];
  info.may_be_infinite = number->coding != SF_FORMAT_PCM_16;
  sound.coding = number->coding | SF_ENDIAN_LITTLE;
  sound.sample_bytes = static_cast<std::size_t>(number->n_bytes);
  sound.first_byte = head_at + static_cast<std::int64_t>(n_head);
  info.description = "NumPy, " + type.substr(1, 3);
  const std::int64_t frame_bytes = number->n_bytes * n_channels;
  const std::int64_t n_held = (bytes.size() - sound.first_byte) / frame_bytes;
  if (n_held < info.n_frames) {
    if (n_held <= 0) refuse("holds no samples; save it again");
    info.warning = "the header promises " + std::to_string(info.n_frames) + " samples, the file holds " +
                   std::to_string(n_held) + ": those were read; is it cut off?";
    info.n_frames = n_held;
  }
  return sound;
}

}  // namespace bouncelab::audio
