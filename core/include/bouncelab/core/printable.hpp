// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

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

}  // namespace bouncelab
