// SPDX-License-Identifier: GPL-3.0-or-later
// Text of other programs as UTF-8 with line feeds.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

void append_utf8(std::string& text, std::uint32_t code) {
  const auto put = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0U | (code >> 6U));
  } else {
    if (code < 0x10000) {
      put(0xE0U | (code >> 12U));
    } else {
      put(0xF0U | (code >> 18U));
      put(0x80U | ((code >> 12U) & 0x3FU));
    }
    put(0x80U | ((code >> 6U) & 0x3FU));
  }
  put(0x80U | (code & 0x3FU));
}

/// Which byte of two is the high one; absent: no UTF-16. Without a mark: text of which more than half is ASCII.
std::optional<std::size_t> high_byte(std::string_view head) {
  if (head.starts_with("\xFF\xFE")) return 1;
  if (head.starts_with("\xFE\xFF")) return 0;
  std::size_t n_zero[2] = {0, 0};
  for (std::size_t k = 0; k < head.size(); ++k)
    if (head[k] == '\0') ++n_zero[k % 2];
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}})
    if (4 * n_zero[at] > head.size() && n_zero[1 - at] == 0) return at;
  return std::nullopt;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t n = utf8_character(text);
    if (n == 0) return false;
    text.remove_prefix(n);
  }
  return true;
}

/// Windows-1252 from 80 to 9F; elsewhere it is Latin-1, Unicode's first 256. 0: not used.
constexpr std::uint16_t kWindows[32] = {0x20AC, 0,      0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                        0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0,      0x017D, 0,
                                        0,      0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                        0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0,      0x017E, 0x0178};

}  // namespace

TextDecoder::TextDecoder(std::string name) : name_(std::move(name)) {}

void TextDecoder::begin(std::string_view head) {
  begun_ = true;
  if (head.starts_with(std::string_view("\xFF\xFE\0\0", 4)) || head.starts_with(std::string_view("\0\0\xFE\xFF", 4)))
    throw FileError(name_, "is text in UTF-32; save it as UTF-8");
  if (head.starts_with("PK\x03\x04"))
    throw FileError(name_, "is a ZIP archive (a spreadsheet, or an export of phyphox); unpack it, or save it as CSV");
  high_byte_ = high_byte(head);
  if (high_byte_)
    skip_ = head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF") ? 2 : 0;
  else
    skip_ = head.starts_with("\xEF\xBB\xBF") ? 3 : 0;
}

void TextDecoder::append(std::string_view bytes, std::string& text) {
  const bool is_first = !begun_;
  if (is_first) begin(bytes);
  bytes.remove_prefix(std::min(skip_, bytes.size()));
  const std::size_t from = text.size();
  if (high_byte_)
    for (const char c : bytes) append_half(c, text);
  else
    text += bytes;
  skip_ = 0;
  if (is_first) {
    // of old Macs, and of Excel for them: no line ends in a line feed
    const std::size_t cr = text.find('\r', from);
    cr_only_ = cr != std::string::npos && cr + 1 < text.size() && text.find('\n', from) == std::string::npos;
  }
  if (cr_only_) std::replace(text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), '\r', '\n');
}

void TextDecoder::append_half(char byte, std::string& text) {
  half_[n_half_++] = static_cast<unsigned char>(byte);
  if (n_half_ < 2) return;
  n_half_ = 0;
  const std::uint32_t unit = 256U * half_[*high_byte_] + half_[1 - *high_byte_];
  const bool low = unit >= 0xDC00 && unit < 0xE000, high = unit >= 0xD800 && unit < 0xDC00;
  if (low != (surrogate_ != 0)) throw FileError(name_, "is damaged UTF-16; save it as UTF-8");
  if (high)
    surrogate_ = unit;
  else
    append_utf8(text, low ? 0x10000U + ((surrogate_ - 0xD800U) << 10U) + (unit - 0xDC00U) : unit);
  if (low) surrogate_ = 0;
}

void TextDecoder::finish() const {
  if (n_half_ != 0 || surrogate_ != 0) throw FileError(name_, "is cut off within a character of UTF-16");
}

std::string decoded_text(std::string_view bytes, const std::string& name) {
  TextDecoder decoder(name);
  std::string text;
  decoder.append(bytes, text);
  decoder.finish();
  if (text.find('\0') != std::string::npos)
    throw FileError(name, "holds bytes 0: it is no text; a table of text or marks are needed");
  if (is_utf8(text)) return text;
  std::string latin;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const std::uint32_t code = byte >= 0x80 && byte < 0xA0 ? kWindows[byte - 0x80] : byte;
    if (code == 0 && byte != 0) throw FileError(name, "is neither UTF-8 nor UTF-16 nor Windows-1252; save it as UTF-8");
    append_utf8(latin, code);
  }
  return latin;
}

}  // namespace bouncelab
