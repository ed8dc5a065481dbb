// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace bouncelab::vamp {

/// The shortest decimal number that is this float: 9.81, not 9.8100004, which the user never typed.
inline std::string decimal(float value) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr;
  return {text.data(), end};
}

/// The double nearest to that decimal number.
inline double decimal_value(float value) {
  const std::string text = decimal(value);
  double number = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace bouncelab::vamp
