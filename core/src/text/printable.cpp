// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/printable.hpp"

#include <cstdint>
#include <vector>

#include "bouncelab/core/utf8.hpp"

namespace bouncelab {
namespace {

/// One character of the result, or the escape that stands for one byte.
struct Glyph {
  std::string text;
  std::size_t width = 1;  // characters
};

std::uint32_t code_point(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  std::uint32_t code = first & (0xFFU >> (character.size() + 1));
  for (const char c : character.substr(1)) code = (code << 6U) | (static_cast<unsigned char>(c) & 0x3FU);
  return code;
}

/// Control characters, line and paragraph separators, and the marks that turn the direction of writing, with which a
/// name can look like another.
bool is_harmful(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x200E || code == 0x200F ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF;
}

std::string escape(char byte) {
  if (byte == '\n') return "\\n";
  if (byte == '\r') return "\\r";
  if (byte == '\t') return "\\t";
  constexpr const char* kDigits = "0123456789abcdef";
  const auto value = static_cast<unsigned char>(byte);
  return {'\\', 'x', kDigits[value / 16], kDigits[value % 16]};
}

std::vector<Glyph> glyphs(std::string_view text) {
  std::vector<Glyph> result;
  while (!text.empty()) {
    const std::size_t size = utf8_character(text);
    if (size > 0 && !is_harmful(code_point(text.substr(0, size)))) {
      result.push_back({std::string(text.substr(0, size)), 1});
      text.remove_prefix(size);
    } else {
      const std::string escaped = escape(text.front());
      result.push_back({escaped, escaped.size()});
      text.remove_prefix(1);
    }
  }
  return result;
}

/// The end of a text, from the begin of a character on.
std::string_view tail(std::string_view text, std::size_t n_bytes) {
  std::string_view end = text.substr(text.size() - n_bytes);
  for (int k = 0; k < 3 && !end.empty() && (static_cast<unsigned char>(end.front()) & 0xC0U) == 0x80U; ++k)
    end.remove_prefix(1);
  return end;
}

std::string head_that_fits(const std::vector<Glyph>& all, std::size_t width) {
  std::string text;
  for (std::size_t k = 0; k < all.size() && all[k].width <= width; width -= all[k].width, ++k) text += all[k].text;
  return text;
}

std::string tail_that_fits(const std::vector<Glyph>& all, std::size_t width) {
  std::size_t first = all.size();
  for (; first > 0 && all[first - 1].width <= width; --first) width -= all[first - 1].width;
  std::string text;
  for (std::size_t k = first; k < all.size(); ++k) text += all[k].text;
  return text;
}

}  // namespace

std::string printable(std::string_view text, std::size_t limit) {
  const std::size_t most_bytes = 4 * limit;  // of `limit` characters
  if (text.size() <= most_bytes) {
    const std::vector<Glyph> all = glyphs(text);
    std::size_t width = 0;
    for (const Glyph& glyph : all) width += glyph.width;
    if (width <= limit) return head_that_fits(all, width);
  }
  const std::string length = " (" + std::to_string(text.size()) + " bytes)";
  const std::size_t half = (limit - length.size() - 3) / 2;
  const std::size_t kept = text.size() < most_bytes ? text.size() : most_bytes;
  return head_that_fits(glyphs(text.substr(0, kept)), half) + "..." + tail_that_fits(glyphs(tail(text, kept)), half) +
         length;
}

}  // namespace bouncelab
