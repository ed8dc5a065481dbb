// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>
#include <version>

namespace bouncelab {

/// Characters of a name or of a cell that a message quotes.
inline constexpr std::size_t kQuoted_characters = 200;
/// Characters of a whole message.
inline constexpr std::size_t kMessage_characters = 1000;

/// A text from outside (a file's name, a cell, a word of the command line) as one line that is safe on a terminal:
/// control characters, line breaks, characters that turn the direction of writing and bytes that are not UTF-8 are
/// written as escape sequences of C (backslash and n, t, r or xff). All else stays as it is; applied twice it gives the
/// same.
/// @param limit  at least 50. A longer text is cut in its middle, "first part...last part (1234 bytes)"; of a path the
///               name at its end stays. Takes the same time for a text of any length.
/// @return at most `limit` characters, valid UTF-8
std::string printable(std::string_view text, std::size_t limit = kQuoted_characters);

/// What recordings are called where they stand together: each by the shortest end of its path that no other path ends
/// with ("a.wav" for "/home/me/a.wav"), else by the whole of it.
std::vector<std::string> short_names(const std::vector<std::string>& paths);

/// A text as one word of a POSIX shell: as it is, or within '...'.
std::string shell_word(std::string_view text);

/// The text with line breaks before words that end beyond `width` bytes of a line; its own line breaks stay.
std::string wrapped(std::string text, std::size_t width);

/// The number of bytes (1 to 4) of the valid UTF-8 character that `text` begins with; 0 where there is none.
std::size_t utf8_character(std::string_view text);
/// The number of a valid UTF-8 character.
std::uint32_t code_point(std::string_view character);

/// What a workbook (.xlsx, .ods, .numbers, .xls) or another ZIP archive is, and what to do, for a message; empty where
/// the file is neither. @param head  its first bytes, some hundred
std::string_view workbook_in(std::string_view head);

/// An open conversion of iconv(3), and what closes it.
using Iconv = std::unique_ptr<void, int (*)(void*)>;

/// Bytes of a text file as text: without a byte order mark; UTF-32 with a mark, UTF-16 with one or where every other
/// byte is 0, as UTF-8; carriage returns that end lines by themselves as line feeds. All else stays as it is.
class TextDecoder {
 public:
  /// @param name  of the file, for messages
  explicit TextDecoder(std::string name);
  /// The next bytes; of the first piece, some thousand bytes or the whole file, it is told what the file is.
  /// @throws FileError naming the encoding that is damaged; a workbook or a ZIP archive
  void append(std::string_view bytes, std::string& text);
  /// @throws FileError where the file ends within a character
  void finish() const;

 private:
  std::string name_, encoding_;
  Iconv iconv_{nullptr, nullptr};  // none for UTF-8
  std::string rest_;               // of a piece, that ended within a character
  bool cr_only_ = false;
};

/// A whole file as UTF-8 by TextDecoder; what is not UTF-8 then is taken for Windows-1252, of which Latin-1 is a part.
/// @throws FileError naming what it is not
std::string decoded_text(std::string_view bytes, const std::string& name);

/// Numbers in a text of any length, as printf writes them; the compiler checks that they are what the format says.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// Without what is unwanted at both ends.
std::string_view trimmed(std::string_view text, std::string_view unwanted = " \t");

/// With small letters of ASCII for capital ones.
std::string lower_case(std::string text);

/// The shortest text that is read as the same number.
std::string number_text(double value);
/// The name that was probably meant: the one reached by the fewest insertions, deletions, replacements and swaps of
/// neighbours, the first of several.
/// @return empty where more than a third of the longer word would have to change
std::string nearest_name(std::string_view typed, const std::vector<std::string>& names);

// Parts of C++20 that the library of one compiler in use lacks, Emscripten 3.1 (LLVM 13 to 14) for the page: the
// standard's where it has them, else the same here. Texts of real numbers there are by fast_float and fmt.
using std::from_chars;
using std::to_chars;

#ifndef __cpp_lib_to_chars
/// @note a number beyond the range of double leaves `value` as it was
std::from_chars_result from_chars(const char* first, const char* last, double& value);
/// The shortest text that is read as the same number, of fixed and scientific notation the shorter.
std::to_chars_result to_chars(char* first, char* last, double value);
/// The shortest text in a notation; only `fixed` is offered.
std::to_chars_result to_chars(char* first, char* last, double value, std::chars_format format);
#endif

/// All of a text as a number, "+1" too; else what is wrong with it, and the number stays as it is.
template <class Number>
std::errc parse_number(std::string_view text, Number& number) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const auto [end, status] = bouncelab::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size())
    return status == std::errc{} ? std::errc::invalid_argument : status;
  number = value;
  return status;
}

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
