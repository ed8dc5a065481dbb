// SPDX-License-Identifier: GPL-3.0-or-later
/// Parts of C++20 that the library of one compiler in use lacks, Emscripten 3.1 (LLVM 13 to 14) for the page: the
/// standard's where it has them, else the same here. Texts of real numbers there are by fast_float and fmt.
#pragma once

#include <bit>
#include <charconv>
#include <memory>
#include <type_traits>
#include <version>

namespace bouncelab {

using std::from_chars;
using std::to_chars;

#ifndef __cpp_lib_to_chars
/// @note a number beyond the range of double leaves `value` as it was
std::from_chars_result from_chars(const char* first, const char* last, double& value);
std::from_chars_result from_chars(const char* first, const char* last, float& value);
/// The shortest text that is read as the same number, of fixed and scientific notation the shorter.
std::to_chars_result to_chars(char* first, char* last, double value);
std::to_chars_result to_chars(char* first, char* last, float value);
/// The shortest text in a notation; only `fixed` is offered.
std::to_chars_result to_chars(char* first, char* last, double value, std::chars_format format);
/// As printf writes it; only `general` is offered.
std::to_chars_result to_chars(char* first, char* last, double value, std::chars_format format, int precision);
#endif

#ifdef __cpp_lib_bit_cast
using std::bit_cast;
#else
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From));
  return __builtin_bit_cast(To, from);
}
#endif

}  // namespace bouncelab
