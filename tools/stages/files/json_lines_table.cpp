// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/table_reader.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::stages {
namespace {

using Json = nlohmann::ordered_json;

/// A column as it grows, one value a row.
struct Growing {
  Column column;
  bool required = true;
  bool in_this_row = false;
  std::size_t first_line = 0, first_line_without = 0;  // 0: none yet
};

/// Puts the numbers and texts of one line into the columns as the parser comes upon them: no tree is built, and nesting
/// costs a bit a level. What the functions return says whether to go on.
class RowParser : public nlohmann::json_sax<Json> {
 public:
  explicit RowParser(std::vector<Growing>& columns) : columns_(columns) {}

  /// @return what is wrong; empty: nothing
  std::string parse(const std::string& line) {
    depth_ = 0;
    fault_.clear();
    target_ = nullptr;
    if (!Json::sax_parse(line, this) && fault_.empty()) fault_ = "is not JSON";
    return fault_;
  }

  bool null() override { return at_value(); }
  bool boolean(bool) override {
    return at_value() && (target_ == nullptr || refuse("true or false where a number or a text is needed"));
  }
  bool number_integer(number_integer_t value) override { return at_value() && put(value); }
  bool number_unsigned(number_unsigned_t value) override {
    if (!at_value()) return false;
    if (value <= static_cast<number_unsigned_t>(std::numeric_limits<std::int64_t>::max()))
      return put(static_cast<std::int64_t>(value));
    if (is_integer_column()) return refuse(std::to_string(value) + " is beyond the range of a 64-bit integer");
    return put(static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t& text) override {
    if (!at_value()) return false;
    if (!is_integer_column()) return put(static_cast<double>(value));
    const auto whole = whole_number(value);
    return whole ? put(*whole) : refuse(printable(text) + " is not an integer, or beyond its range");
  }
  bool string(string_t& value) override {
    if (!at_value() || target_ == nullptr) return fault_.empty();
    auto* texts = std::get_if<std::vector<std::string>>(&target_->column.values);
    if (texts == nullptr) return refuse("'" + printable(value) + "' is not a number");
    if (value.find('\0') != std::string::npos) return refuse("a text holds the character 0");
    texts->push_back(bytes_of_utf8(value));
    return taken();
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override {
    if (depth_ > 0 && !at_value()) return false;
    return depth_++ == 0 || target_ == nullptr || refuse("an object where a number or a text is needed");
  }
  bool key(string_t& name) override {
    if (depth_ > 1) return true;
    const auto found = std::find_if(columns_.begin(), columns_.end(),
                                    [&](const Growing& growing) { return growing.column.name == name; });
    target_ = found == columns_.end() ? nullptr : &*found;
    if (target_ == nullptr) return true;
    if (target_->in_this_row) return refuse("stands there twice");
    target_->in_this_row = true;
    return true;
  }
  bool end_object() override { return depth_-- > 0; }
  bool start_array(std::size_t) override {
    if (!at_value()) return false;
    ++depth_;
    return target_ == nullptr || refuse("a list where a number or a text is needed");
  }
  bool end_array() override { return depth_-- > 0; }
  bool parse_error(std::size_t at, const std::string& token, const nlohmann::detail::exception& error) override {
    constexpr int kTooLargeNumber = 406;
    return refuse("'" + printable(token) + "' " +
                  (error.id == kTooLargeNumber ? "is beyond the range of a 64-bit real"
                                               : "is not JSON, at character " + std::to_string(at)));
  }

 private:
  bool refuse(const std::string& what) {
    fault_ = (target_ != nullptr ? "key " + target_->column.name + ": " : std::string()) + what;
    return false;
  }
  bool at_value() { return depth_ > 0 || refuse("is not a JSON object; one is needed on each line"); }
  bool is_integer_column() const {
    return target_ != nullptr && std::holds_alternative<std::vector<std::int64_t>>(target_->column.values);
  }
  bool taken() {
    target_ = nullptr;
    return true;
  }
  template <class Number>
  bool put(Number value) {
    if (target_ == nullptr) return true;
    if (auto* reals = std::get_if<std::vector<double>>(&target_->column.values))
      reals->push_back(static_cast<double>(value));
    else if (auto* integers = std::get_if<std::vector<std::int64_t>>(&target_->column.values))
      integers->push_back(static_cast<std::int64_t>(value));
    else
      return refuse("a number where a text is needed");
    return taken();
  }

  std::vector<Growing>& columns_;
  std::size_t depth_ = 0;
  Growing* target_ = nullptr;  // of the value that comes next
  std::string fault_;
};

std::size_t size_of(const Column& column) {
  return std::visit([](const auto& values) { return values.size(); }, column.values);
}

/// Fills what the row did not have; an integer stands there as 0 until take_columns() refuses it.
void end_row(std::vector<Growing>& columns, std::size_t n_rows, std::size_t line) {
  for (Growing& growing : columns) {
    growing.in_this_row = false;
    const bool absent = size_of(growing.column) < n_rows;
    std::size_t& first = absent ? growing.first_line_without : growing.first_line;
    if (first == 0) first = line;
    if (!absent) continue;
    if (auto* reals = std::get_if<std::vector<double>>(&growing.column.values))
      reals->push_back(std::numeric_limits<double>::quiet_NaN());
    else
      std::visit([](auto& values) { values.emplace_back(); }, growing.column.values);
  }
}

std::string line_text(std::size_t number) { return "line " + std::to_string(number); }

class JsonLinesReader final : public TableReader {
 public:
  JsonLinesReader(std::istream& in, const std::string& name, const std::vector<ColumnSpec>& wanted) : lines_(in, name) {
    add_columns(wanted);
  }
  JsonLinesReader(std::ifstream&& in, const std::string& name, const std::vector<ColumnSpec>& wanted)
      : file_(std::move(in)), lines_(file_, name) {
    add_columns(wanted);
  }

  Table next(std::size_t max_rows) override {
    Table table;
    std::size_t n_rows = 0;
    for (std::string line; n_rows < max_rows && lines_.next(line);) {
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      if (const std::string fault = parser_.parse(line); !fault.empty())
        throw FileError(lines_.name(), line_text(lines_.number()) + ": " + fault);
      table.stands_on(n_rows++, lines_.number());
      end_row(columns_, n_rows, lines_.number());
    }
    is_empty_ = is_empty_ && n_rows == 0;
    if (is_empty_ && max_rows > 0) throw FileError(lines_.name(), "is empty; one JSON object on each line is needed");
    take_columns(table);
    return table;
  }

 private:
  void add_columns(const std::vector<ColumnSpec>& wanted) {
    for (const ColumnSpec& spec : wanted) columns_.push_back({empty_column(spec), spec.required});
  }

  /// Those that any row had up to now.
  void take_columns(Table& table) {
    for (Growing& growing : columns_) {
      const std::string& key = growing.column.name;
      if (growing.first_line == 0 && growing.required)
        throw FileError(lines_.name(), line_text(growing.first_line_without) + ": the key '" + key + "' is missing");
      const bool is_integer = std::holds_alternative<std::vector<std::int64_t>>(growing.column.values);
      if (is_integer && growing.first_line != 0 && growing.first_line_without != 0)
        throw FileError(lines_.name(), line_text(growing.first_line_without) + ": the key '" + key +
                                           "' is missing, but " + line_text(growing.first_line) +
                                           " has it; integers must be in all rows or in none");
      Column taken{key, std::visit([](auto& values) -> decltype(Column::values) { return std::exchange(values, {}); },
                                   growing.column.values)};
      if (growing.first_line != 0) table.columns.push_back(std::move(taken));
    }
  }

  std::ifstream file_;
  LineReader lines_;
  std::vector<Growing> columns_;
  RowParser parser_{columns_};
  bool is_empty_ = true;
};

}  // namespace

std::unique_ptr<TableReader> json_lines_reader(std::istream& in, const std::string& name,
                                               const std::vector<ColumnSpec>& wanted) {
  return std::make_unique<JsonLinesReader>(in, name, wanted);
}

std::unique_ptr<TableReader> json_lines_reader(const std::filesystem::path& path,
                                               const std::vector<ColumnSpec>& wanted) {
  return std::make_unique<JsonLinesReader>(open_text(path), input_name(path), wanted);
}

void write_json_lines(std::ostream& out, const Table& table) {
  for (std::size_t row = 0; row < table.n_rows(); ++row) {
    Json object = Json::object();
    for (const Column& column : table.columns)
      std::visit(
          [&](const auto& values) {
            using Value = typename std::decay_t<decltype(values)>::value_type;
            if constexpr (std::is_same_v<Value, std::string>) {
              object[column.name] = utf8_of_bytes(values[row]);
            } else {
              // JSON has no infinity
              if (std::isfinite(static_cast<double>(values[row]))) object[column.name] = values[row];
            }
          },
          column.values);
    out << object.dump() << '\n';
  }
}

}  // namespace bouncelab::stages
