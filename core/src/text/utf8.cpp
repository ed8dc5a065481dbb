// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/utf8.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kStandIn_bytes = 3;

/// U+EF80 to U+EFFF: EE BE 80 to EE BF BF.
bool is_stand_in(std::string_view character) {
  return character.size() == kStandIn_bytes && character[0] == '\xEE' &&
         (character[1] == '\xBE' || character[1] == '\xBF');
}

void append_stand_in(char byte, std::string& text) {
  const auto value = static_cast<unsigned char>(byte);
  text += '\xEE';
  text += static_cast<char>(value < 0xC0 ? 0xBE : 0xBF);
  text += static_cast<char>(0x80U | (value & 0x3FU));
}

char byte_of_stand_in(std::string_view character) {
  const unsigned high = character[1] == '\xBE' ? 0x80U : 0xC0U;
  return static_cast<char>(high | (static_cast<unsigned char>(character[2]) & 0x3FU));
}

}  // namespace

std::size_t utf8_character(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < size) return 0;
  for (std::size_t k = 1; k < size; ++k)
    if ((byte(k) & 0xC0U) != 0x80U) return 0;
  const unsigned second = byte(1);
  const bool too_long = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second >= 0xA0;
  const bool beyond = first == 0xF4 && second >= 0x90;
  return too_long || surrogate || beyond ? 0 : size;
}

std::string utf8_of_bytes(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  while (!bytes.empty()) {
    const std::size_t size = utf8_character(bytes);
    const std::string_view character = bytes.substr(0, size);
    if (size > 0 && !is_stand_in(character)) {
      text += character;
      bytes.remove_prefix(size);
    } else {
      append_stand_in(bytes.front(), text);
      bytes.remove_prefix(1);
    }
  }
  return text;
}

std::string bytes_of_utf8(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size());
  while (!text.empty()) {
    const std::string_view three = text.substr(0, kStandIn_bytes);
    if (utf8_character(three) == kStandIn_bytes && is_stand_in(three)) {
      bytes += byte_of_stand_in(three);
      text.remove_prefix(kStandIn_bytes);
    } else {
      bytes += text.front();
      text.remove_prefix(1);
    }
  }
  return bytes;
}

}  // namespace bouncelab
