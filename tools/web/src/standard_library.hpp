// SPDX-License-Identifier: GPL-3.0-or-later
/// What the C++ library of Emscripten 3.1 (LLVM 13 to 14) lacks of C++20, included before everything else (-include):
/// texts of floating-point numbers, by fast_float and fmt, std::bit_cast and std::make_unique_for_overwrite. Values and
/// texts are those of other libraries.
#pragma once

#include <bit>
#include <charconv>
#include <memory>
#include <type_traits>
#include <version>

#ifndef __cpp_lib_to_chars
namespace std {
/// @note a number beyond the range of double leaves `value` as it was
from_chars_result from_chars(const char* first, const char* last, double& value,
                             chars_format format = chars_format::general);
from_chars_result from_chars(const char* first, const char* last, float& value,
                             chars_format format = chars_format::general);
/// The shortest text that is read as the same number, of fixed and scientific notation the shorter.
to_chars_result to_chars(char* first, char* last, double value);
to_chars_result to_chars(char* first, char* last, float value);
/// The shortest text in a notation; only `fixed` is offered.
to_chars_result to_chars(char* first, char* last, double value, chars_format format);
/// As printf writes it; only `general` is offered.
to_chars_result to_chars(char* first, char* last, double value, chars_format format, int precision);
}  // namespace std
#endif

#ifndef __cpp_lib_smart_ptr_for_overwrite
namespace std {
template <class Array>
requires is_unbounded_array_v<Array> unique_ptr<Array> make_unique_for_overwrite(size_t n) {
  return unique_ptr<Array>(new remove_extent_t<Array>[n]);
}
}  // namespace std
#endif

#ifndef __cpp_lib_bit_cast
namespace std {
template <class To, class From>
requires(sizeof(To) == sizeof(From) && is_trivially_copyable_v<To> && is_trivially_copyable_v<From>) constexpr To
    bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}
}  // namespace std
#endif
