// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/numbers.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "bouncelab/core/text.hpp"

namespace bouncelab::cli {
namespace {

/// Absent where the text is not one decimal number that T holds, with or without a sign.
template <class T>
std::optional<T> decimal(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> finite(std::string_view text) {
  const std::optional<double> value = decimal<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string refusal(const std::string& text, const std::string& range) {
  return fmt::format("'{}' must be {}", printable(text), range);
}

template <class T>
std::string range_text(T lo, T hi) {
  return fmt::format("{} to {}", lo, hi);
}

CLI::Validator within_integers(std::int64_t lo, std::int64_t hi) {
  const std::string range = range_text(lo, hi);
  return {[=](std::string& text) {
            const auto value = decimal<std::int64_t>(text);
            return value && *value >= lo && *value <= hi ? "" : refusal(text, "a decimal integer from " + range);
          },
          range};
}

/// The numbers between commas; absent where one is none.
std::optional<std::vector<double>> list_of(std::string_view text) {
  std::vector<double> values;
  while (true) {
    const auto comma = text.find(',');
    const std::optional<double> value = finite(text.substr(0, comma));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string_view::npos) return values;
    text.remove_prefix(comma + 1);
  }
}

/// Rewrites an integer as CLI11, which reads C literals, takes it for the same.
template <class T>
CLI::Validator decimal_integer(std::string range) {
  if (range.empty()) range = range_text(std::numeric_limits<T>::min(), std::numeric_limits<T>::max());
  return {[range](std::string& text) {
            const auto value = decimal<T>(text);
            if (!value) return refusal(text, "a decimal integer from " + range);
            text = std::to_string(*value);
            return std::string{};
          },
          ""};
}

CLI::Validator decimal_real(const std::string& range) {
  return {[range](std::string& text) {
            return finite(text) ? ""
                                : refusal(text, "a finite decimal number" + (range.empty() ? "" : " from " + range));
          },
          ""};
}

}  // namespace

std::pair<std::string, std::string> type_and_range(const CLI::Option& option) {
  const std::string both = option.get_type_name();
  const auto colon = both.find(':');
  return {both.substr(0, colon), colon == std::string::npos ? "" : both.substr(colon + 1)};
}

CLI::Validator within(double lo, double hi) {
  const std::string range = range_text(lo, hi);
  return {[=](std::string& text) {
            const std::optional<double> value = finite(text);
            return value && *value >= lo && *value <= hi ? "" : refusal(text, "a finite decimal number from " + range);
          },
          range};
}

CLI::Validator within(std::int64_t lo, std::int64_t hi) { return within_integers(lo, hi); }
CLI::Validator within(int lo, int hi) { return within_integers(lo, hi); }

CLI::Option* add_list(CLI::App& app, const std::string& name, std::vector<double>& values, const std::string& shape,
                      std::size_t n_min, std::size_t n_max, double lo, double hi, const std::string& help) {
  const auto read = [&values](const std::string& text) { values = list_of(text).value_or(values); };
  const std::string count =
      n_min == n_max ? std::to_string(n_min) : std::to_string(n_min) + " or " + std::to_string(n_max);
  const auto problem = [=](const std::string& text) -> std::string {
    const auto list = list_of(text);
    if (!list || list->size() < n_min || list->size() > n_max)
      return refusal(text, count + " finite decimal numbers, " + shape);
    for (const double value : *list)
      if (!(value >= lo && value <= hi)) return refusal(text, "numbers from " + range_text(lo, hi));
    return "";
  };
  return app.add_option_function<std::string>(name, read, help)
      ->type_name(shape)
      ->default_str(fmt::format("{}", fmt::join(values, ",")))
      ->check(problem, range_text(lo, hi));
}

bool takes_list(const CLI::Option& option) { return type_and_range(option).first.find(',') != std::string::npos; }

void read_numbers_in_decimal(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    const auto [type, range] = type_and_range(*option);
    if (type == "INT") option->transform(decimal_integer<std::int64_t>(range));
    if (type == "UINT") option->transform(decimal_integer<std::uint64_t>(range));
    if (type == "FLOAT") option->transform(decimal_real(range));
  }
}

}  // namespace bouncelab::cli
