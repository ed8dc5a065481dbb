// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/foreign_table.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "tables/title_words.hpp"

namespace bouncelab {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text, std::string_view unwanted) {
  const std::size_t first = text.find_first_not_of(unwanted);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(unwanted) - first + 1);
}

/// Half a unit of the last digit of 12.50e-3: 5e-6.
double rounding_of(std::string_view number) {
  const std::size_t exponent_at = std::min(number.find_first_of("eE"), number.size());
  const std::string_view mantissa = number.substr(0, exponent_at);
  const std::size_t point = mantissa.find('.');
  const double n_decimals = point == std::string_view::npos ? 0.0 : static_cast<double>(mantissa.size() - point - 1);
  int exponent = 0;
  if (exponent_at < number.size()) {
    const char* begin = number.data() + exponent_at + 1;
    if (begin < number.data() + number.size() && *begin == '+') ++begin;
    bouncelab::from_chars(begin, number.data() + number.size(), exponent);
  }
  return 0.5 * pow(10.0, exponent - n_decimals);
}

}  // namespace

std::vector<std::string> words_of(std::string_view title) {
  std::vector<std::string> words(1);
  for (const char c : title) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80 || std::isalpha(byte) != 0)
      words.back() += static_cast<char>(byte < 0x80 ? std::tolower(byte) : byte);
    else if (!words.back().empty())
      words.emplace_back();
  }
  return words;
}

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  if (separator == ' ') line = trimmed(line, kBlanks);
  while (true) {
    std::size_t end = std::min(separator == ' ' ? line.find_first_of(kBlanks) : line.find(separator), line.size());
    const std::size_t quote = line.find_first_not_of(kBlanks);
    if (end < line.size() && quote < end && line[quote] == '"') {
      const std::size_t closing = line.find('"', quote + 1);  // doubled quotes: two texts that touch
      if (closing != std::string_view::npos && closing > end)
        end = std::min(separator == ' ' ? line.find_first_of(kBlanks, closing) : line.find(separator, closing),
                       line.size());
    }
    cells.push_back(trimmed(line.substr(0, end), " \t\r\""));
    if (end == line.size()) return cells;
    line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line, kBlanks);
  }
}

namespace {

std::optional<NumberCell> plain_number_of(std::string_view cell, char decimal) {
  std::array<char, 512> text{};  // a double without an exponent has up to 400
  if (cell.empty() || cell.size() > text.size()) return std::nullopt;
  if (cell.front() == '+') cell.remove_prefix(1);
  std::copy(cell.begin(), cell.end(), text.begin());
  const std::string_view number(text.data(), cell.size());
  if (decimal == ',') {
    if (number.find('.') != std::string_view::npos) return std::nullopt;
    std::replace(text.begin(), text.end(), ',', '.');
  }
  double value = 0.0;
  const auto [end, error] = bouncelab::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(value)) return std::nullopt;
  return NumberCell{value, rounding_of(number)};
}

}  // namespace

std::optional<NumberCell> number_of(std::string_view cell, char decimal) {
  const std::size_t colon = cell.rfind(':');
  if (colon == std::string_view::npos) return plain_number_of(cell, decimal);
  // a clock time: hours and minutes are whole numbers
  std::optional<NumberCell> result = plain_number_of(cell.substr(colon + 1), decimal);
  if (!result || !(result->value >= 0.0 && result->value < 60.0)) return std::nullopt;
  double unit_s = 60.0;
  std::string_view rest = cell.substr(0, colon);
  for (int k = 0; k < 2; ++k, unit_s *= 60.0) {
    const std::size_t before = rest.rfind(':');
    const std::string_view digits = before == std::string_view::npos ? rest : rest.substr(before + 1);
    if (digits.empty() || digits.size() > 4 || digits.find_first_not_of("0123456789") != std::string_view::npos)
      return std::nullopt;
    result->value += unit_s * plain_number_of(digits, '.')->value;
    if (before == std::string_view::npos) {
      result->is_clock = true;
      return result;
    }
    rest = rest.substr(0, before);
  }
  return std::nullopt;
}

std::optional<CellFormat> format_of(std::string_view line) {
  constexpr std::array<CellFormat, 7> kFormats{
      {{'\t', '.'}, {'\t', ','}, {';', '.'}, {';', ','}, {',', '.'}, {' ', '.'}, {' ', ','}}};
  for (const CellFormat& format : kFormats) {
    if (format.separator != ' ' && line.find(format.separator) == std::string_view::npos) continue;
    int n_numbers = 0, n_others = 0;
    for (const std::string_view cell : cells_of(line, format.separator)) {
      if (cell.empty()) continue;
      ++(number_of(cell, format.decimal) ? n_numbers : n_others);
    }
    if (n_numbers > 0 && n_others == 0) return format;
  }
  return std::nullopt;
}

bool is_ambiguous(std::string_view line, const CellFormat& format) {
  if (format.separator != ',') return false;
  const std::vector<std::string_view> cells = cells_of(line, ',');
  const auto is_digits = [](std::string_view cell) {
    return !cell.empty() && std::all_of(cell.begin(), cell.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  const auto without_sign = [](std::string_view cell) {
    return cell.substr(!cell.empty() && (cell.front() == '-' || cell.front() == '+') ? 1 : 0);
  };
  return cells.size() == 2 && is_digits(without_sign(cells[0])) && is_digits(cells[1]);
}

namespace {

bool holds_any(const std::vector<std::string>& words, std::initializer_list<std::string_view> of) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& word) { return std::find(of.begin(), of.end(), word) != of.end(); });
}

bool says_time(const std::vector<std::string>& words) {
  return holds_any(words, {"time", "t", "zeit", "temps", "tiempo", "tempo", "tid"});
}

}  // namespace

std::optional<double> time_unit_s(std::string_view title) {
  constexpr std::array<std::pair<std::string_view, double>, 21> kUnits{
      {{"s", 1.0},           {"sec", 1.0},        {"second", 1.0},       {"seconds", 1.0},       {"sekunde", 1.0},
       {"sekunden", 1.0},    {"seconde", 1.0},    {"secondes", 1.0},     {"segundos", 1.0},      {"cs", 1e-2},
       {"ds", 0.1},          {"ms", 1e-3},        {"millisecond", 1e-3}, {"milliseconds", 1e-3}, {"us", 1e-6},
       {"\xC2\xB5s", 1e-6},  {"\xCE\xBCs", 1e-6}, {"microsecond", 1e-6}, {"microseconds", 1e-6}, {"ns", 1e-9},
       {"nanoseconds", 1e-9}}};
  const std::vector<std::string> words = words_of(title);
  for (const std::string& word : words)
    for (const auto& [name, unit_s] : kUnits)
      if (word == name) return unit_s;
  // by itself "min" is the least of something, and h a height
  if (says_time(words) && holds_any(words, {"min", "minute", "minutes", "minuten", "minutos"})) return 60.0;
  if (says_time(words) && holds_any(words, {"h", "hour", "hours", "stunden", "heures", "horas"})) return 3600.0;
  return std::nullopt;
}

bool names_derived(std::string_view title) {
  for (const std::string_view sign : {"^2", "^3", "**", "10^", "\xC2\xB2", "\xC2\xB3", "\xE2\x88\x9A"})
    if (title.find(sign) != std::string_view::npos) return true;
  constexpr std::string_view kDigits = "0123456789";
  for (std::size_t begin = 0; begin <= title.size();) {
    const std::size_t end = std::min(title.find_first_of("()[]", begin), title.size());
    const std::string_view part = trimmed(title.substr(begin, end - begin), kBlanks);
    // something is taken from a number or divides it
    const std::size_t sign = part.find_first_not_of("0123456789. ");
    if (part.find_first_of(kDigits) == 0 && sign < part.size() && (part[sign] == '-' || part[sign] == '/')) return true;
    const bool is_in_brackets = end < title.size() && (title[end] == ')' || title[end] == ']');
    if (is_in_brackets && part.find_first_of(kDigits) != std::string_view::npos && time_unit_s(part)) return true;
    begin = end + 1;
  }
  return holds_any(
      words_of(title),
      {"sqrt",        "log",          "ln",      "lg",          "squared", "half",     "halbe", "rate",   "hz",
       "frequency",   "frequenz",     "contact", "kontaktzeit", "sigma",   "\xCF\x83", "error", "err",    "fehler",
       "uncertainty", "unsicherheit", "std",     "stdev",       "sd",      "inverse",  "loss",  "verlust"});
}

bool names_time(std::string_view title) { return says_time(words_of(title)); }

bool is_time_title(std::string_view title) { return says_time(words_of(title)) || time_unit_s(title).has_value(); }

}  // namespace bouncelab
