// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace bouncelab {

/// The number of bytes (1 to 4) of the valid UTF-8 character that `text` begins with; 0 where there is none.
std::size_t utf8_character(std::string_view text);

/// Any bytes, names of files for instance, as valid UTF-8 that bytes_of_utf8 turns back into the same bytes. Valid
/// UTF-8 stays as it is; a byte b that belongs to no character becomes the private character U+EF00 + b (so that b from
/// 80 to FF gives U+EF80 to U+EFFF, as in the OPTU-8 encoding of MirBSD). These 128 characters themselves are taken
/// for three such bytes each.
std::string utf8_of_bytes(std::string_view bytes);
/// The inverse of utf8_of_bytes.
std::string bytes_of_utf8(std::string_view text);

}  // namespace bouncelab
