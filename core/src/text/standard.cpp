// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/text.hpp"

#ifndef __cpp_lib_to_chars

#include <fast_float/fast_float.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace bouncelab {
namespace {

/// Has the text of a number another digit than 0 before its exponent?
bool is_not_zero(std::string_view text) {
  return text.substr(0, text.find_first_of("eE")).find_first_of("123456789") != std::string_view::npos;
}

std::to_chars_result put(char* first, char* last, std::string_view text) {
  if (last - first < static_cast<std::ptrdiff_t>(text.size())) return {last, std::errc::value_too_large};
  std::memcpy(first, text.data(), text.size());
  return {first + text.size(), std::errc{}};
}

/// A number as sign, digits d_1 d_2 ... without zeros at the end, and exponent: d_1.d_2... 10^exponent.
struct Decimal {
  std::string sign, digits;
  int exponent = 0;
};

/// The shortest digits, from fmt's text of the number, in which the point may stand anywhere and an exponent follow.
Decimal shortest(double value) {
  const std::string text = fmt::format("{}", std::abs(value));
  const auto e = std::min(text.find('e'), text.size()), point = std::min(text.find('.'), e);
  Decimal decimal{std::signbit(value) ? "-" : "", "", e < text.size() ? std::atoi(text.c_str() + e + 1) : 0};
  decimal.exponent += static_cast<int>(point) - 1;
  for (const char c : text.substr(0, e))
    if (c != '.') decimal.digits += c;
  const auto n_zeros = decimal.digits.find_first_not_of('0');
  if (n_zeros == std::string::npos) return {decimal.sign, "0", 0};
  decimal.digits.erase(0, n_zeros);
  decimal.exponent -= static_cast<int>(n_zeros);
  while (decimal.digits.back() == '0') decimal.digits.pop_back();
  return decimal;
}

std::string fixed(const Decimal& d) {
  const int n = static_cast<int>(d.digits.size());
  if (d.exponent < 0) return d.sign + "0." + std::string(static_cast<std::size_t>(-d.exponent - 1), '0') + d.digits;
  if (n <= d.exponent + 1) return d.sign + d.digits + std::string(static_cast<std::size_t>(d.exponent + 1 - n), '0');
  const auto point = static_cast<std::size_t>(d.exponent + 1);
  return d.sign + d.digits.substr(0, point) + "." + d.digits.substr(point);
}

std::string scientific(const Decimal& d) {
  return d.sign + d.digits.substr(0, 1) + (d.digits.size() > 1 ? "." : "") + d.digits.substr(1) +
         fmt::format("e{}{:02}", d.exponent < 0 ? '-' : '+', std::abs(d.exponent));
}

}  // namespace

std::from_chars_result from_chars(const char* first, const char* last, double& value) {
  double read = 0.0;
  const auto [end, status] = fast_float::from_chars(first, last, read);
  if (status != std::errc{}) return {end, status};
  // fast_float 3 rounds to infinity and zero in silence
  const std::string_view text(first, static_cast<std::size_t>(end - first));
  const bool is_word = text.find_first_of("nN") != std::string_view::npos;
  if (!is_word && (std::isinf(read) || (read == 0 && is_not_zero(text)))) return {end, std::errc::result_out_of_range};
  value = read;
  return {end, std::errc{}};
}

std::to_chars_result to_chars(char* first, char* last, double value) {
  if (!std::isfinite(value)) return put(first, last, fmt::format("{}", value));
  const Decimal decimal = shortest(value);
  const std::string a = fixed(decimal), b = scientific(decimal);
  // of integers above 2^53 all digits are written in fixed notation, which is then the longer one anyway
  return put(first, last, b.size() < a.size() ? b : a);
}

std::to_chars_result to_chars(char* first, char* last, double value, std::chars_format) {
  if (!std::isfinite(value)) return put(first, last, fmt::format("{}", value));
  return put(first, last, fixed(shortest(value)));
}

}  // namespace bouncelab

#endif
